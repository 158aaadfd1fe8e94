#pragma once

#include <optional>
#include <vector>

#include "core/contact_problem.h"
#include "core/quad_matrix.h"

namespace lcpbench {

/// The inertia G of a contact problem and its (pseudo-)inverse G*, in 113-bit arithmetic.
///
/// - Dense and block: G* = G^-1 by LDL' where G is regular: each pivot keeps 2^-40 of its diagonal entry, or 2^-96
///   where G is also proven positive definite.
/// - Factors: G = X diag(alpha) X'. As dense where there are at least ngc of them and G is regular. Else, with Q an
///   orthonormal basis of the range of X (column-pivoted Gram-Schmidt with a second pass), G* = Q (Q'GQ)^-1 Q'; a
///   factor belongs to the range of the others if at most 2^-48 of its length is orthogonal to it: far above the
///   rounding of the arithmetic (2^-113), far below the angle 2^-26 that the same decision on G in double could still
///   see.
/// - Dense G, or a block of order n, that is not regular: its pivoted LDL' is cut at n 2^-52 max G_ii, the cut of
///   inverse_inertia(), and the factors kept are treated as above.
/// - G* given: it is used as it is; G is then unknown.
class QuadInertia {
 public:
  explicit QuadInertia(const Inertia& inertia);

  std::size_t dimension() const { return dimension_; }

  /// False when no G* could be made of the data (not finite, or indefinite): solve() must not be called.
  bool well_defined() const { return well_defined_; }

  /// False when only G* was given: apply() and scale() must not be called.
  bool has_inertia() const { return has_inertia_; }

  /// Proven in 113-bit arithmetic with all rounding bounded (of G*, where only that was given). O(ngc^3).
  bool proven_positive_definite() const;

  /// x := G* x, for ngc entries.
  void solve(QuadVector& x) const;

  /// x := G* x for an x with entries only in the rows of `pattern`; `pattern` becomes the rows of the result.
  /// Costs the blocks that are touched, not ngc.
  void solve(QuadVector& x, std::vector<std::size_t>& pattern) const;

  /// G x.
  QuadVector apply(const QuadVector& x) const;

  /// |G| x: the scale of rounding in G x for x >= 0. |G*| x where only that was given.
  QuadVector scale(const QuadVector& x) const;

  /// x less its orthogonal projection on the range of G: zero when G has full rank or is unknown.
  QuadVector outside_range(const QuadVector& x) const;

 private:
  struct Block {
    std::size_t offset = 0;
    QuadMatrix matrix;                ///< G, or the given G*
    std::size_t formation_terms = 0;  ///< roundings that forming an entry of `matrix` took
    bool is_inverse = false;
    std::optional<QuadMatrix> range;  ///< size x rank, orthonormal; empty when the rank is full
    QuadCholesky factor;              ///< of G, or of range' G range

    std::size_t size() const { return matrix.rows; }
    void solve(Quad* x) const;
  };

  void add_inertia(const Matrix& G);
  void add_factors(const QuadMatrix& X, const QuadVector& alpha);
  void add_inverse(const Matrix& Ginv);
  static bool factor_regular(Block& block);
  bool factor_in_range(Block& block, const QuadMatrix& X, const QuadVector& alpha);
  void add(Block block);

  std::vector<Block> blocks_;
  std::vector<std::size_t> block_of_row_;
  std::size_t dimension_ = 0;
  bool well_defined_ = true;
  bool has_inertia_ = true;
};

}  // namespace lcpbench
