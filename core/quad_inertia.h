#pragma once

#include <optional>
#include <vector>

#include "core/contact_problem.h"
#include "core/exact_inertia.h"
#include "core/quad_matrix.h"

namespace lcpbench {

/// The inertia G of a contact problem and its (pseudo-)inverse G*, in 113-bit arithmetic: the definition of
/// ExactResponse, with a bound on the rounding.
///
/// - G regular: G* = G^-1 by LDL', where G scaled to unit diagonal is proven to have no eigenvalue below 2^-64.
/// - Fewer factors than coordinates: G* = X K^-1 diag(alpha)^-1 K^-1 X' with K = X'X, where the same is proven of K.
/// - Where neither is proven, exact integers decide and give G*, up to kMostExactCoordinates. Beyond, the inertia is
///   unresolved.
/// - A given G, or block, that is indefinite by rounding: its pivoted LDL' is cut at n 2^-52 max G_ii, and G* is the
///   pseudo-inverse with the range of the columns kept.
/// - G* given: it is used as it is; G is then unknown.
class QuadInertia {
 public:
  explicit QuadInertia(const Inertia& inertia);

  std::size_t dimension() const { return dimension_; }

  /// False when no G* could be made of the data (not finite, indefinite, or unresolved): solve() must not be called.
  bool well_defined() const { return well_defined_ && !unresolved_; }
  /// Neither 113 bits nor exact integers of the length that is allowed tell what G* is.
  bool unresolved() const { return unresolved_; }
  /// Whether 113 bits did not tell what G* of some block is, and exact integers did.
  bool needs_exact() const { return needs_exact_; }
  /// Whether a block is indefinite by rounding: exact arithmetic has no G* of it.
  bool is_cut() const { return is_cut_; }

  /// A bound b_i by coordinate: rounding of y = G* x and of x = J f changes no j'y by more than the sum of |j_i| b_i.
  /// `terms` = |J| |f|. 0 for a block that is cut.
  std::vector<double> rounding(const QuadVector& x, const QuadVector& terms, const QuadVector& y) const;

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
    std::optional<QuadMatrix> range;    ///< size x rank, orthonormal; empty when the rank is full
    std::optional<QuadMatrix> columns;  ///< independent factors, scaled to unit length
    QuadVector weights;                 ///< alpha_k |x_k|^2, so that G = columns diag(weights) columns'
    QuadCholesky factor;                ///< of G, or of columns'columns, or of range' G range
    double least = 0;                   ///< proven of the eigenvalues of what is factored, scaled to unit diagonal
    std::optional<ExactResponse> exact;

    std::size_t size() const { return matrix.rows; }
    void solve(Quad* x) const;
    void bound(const Quad* x, const Quad* terms, const Quad* y, double* bounds) const;
  };

  void add_inertia(const Matrix& G);
  void add_factors(const FactoredInertia& factors);
  void add_inverse(const Matrix& Ginv);
  void resolve(const Inertia& inertia, Block& block);
  void cut(Block& block);
  static bool factor_regular(Block& block);
  static bool factor_independent(Block& block, const QuadMatrix& X, const QuadVector& alpha);
  void add(Block block);

  std::vector<Block> blocks_;
  std::vector<std::size_t> block_of_row_;
  std::size_t dimension_ = 0;
  bool well_defined_ = true;
  bool has_inertia_ = true;
  bool unresolved_ = false;
  bool needs_exact_ = false;
  bool is_cut_ = false;
};

}  // namespace lcpbench
