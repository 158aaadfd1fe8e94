#pragma once

#include <optional>
#include <vector>

#include "core/contact_problem.h"
#include "core/quad_matrix.h"

namespace lcpbench {

/// The inertia G of a contact problem and its (pseudo-)inverse G*, in 113-bit arithmetic.
///
/// - G regular: G* = G^-1 by LDL', where G scaled to unit diagonal is proven to have no eigenvalue below 2^-64.
/// - Fewer factors than coordinates: G* = X K^-1 diag(alpha)^-1 K^-1 X' with K = X'X, where the same is proven of K.
/// - Where neither is proven, pivoting finds the rank. G* = B (B'G B)^-1 B' with an orthonormal basis B of the range.
///   The rank has to have a visible gap: each column of B adds at least 2^-90 of the length of one of G or X, and at
///   most 2^-104 of the length of each is left outside. Of factors W = X diag(alpha)^1/2, each row of B'W has 2^-64 of
///   its length outside the span of the rows before it. B'G B of a given G has no diagonal entry below 2^-40 of the
///   largest, and scaled to unit diagonal it is proven to have no eigenvalue below 2^-64. The rank is the same, with
///   the same gap, when the rows of G or W are scaled to unit length. Without a gap the inertia is unresolved.
/// - A given G, or block, that is indefinite by rounding: its pivoted LDL' is cut before the first pivot of at most
///   n 2^-52 max G_ii, and G* is the pseudo-inverse with the range of the columns kept. G is refused if what is left
///   has an entry above n times that bound.
/// - G* given: it is used as it is; G is then unknown.
class QuadInertia {
 public:
  explicit QuadInertia(const Inertia& inertia);

  std::size_t dimension() const { return dimension_; }

  /// False when no G* could be made of the data (not finite, indefinite, or unresolved): solve() must not be called.
  bool well_defined() const { return well_defined_ && !unresolved_; }
  /// 113 bits do not tell the rank.
  bool unresolved() const { return unresolved_; }
  /// Whether a block is indefinite by rounding: its G* is a matter of definition.
  bool is_cut() const { return is_cut_; }

  /// False when only G* was given: apply() and scale() must not be called.
  bool has_inertia() const { return has_inertia_; }

  /// Proven in 113-bit arithmetic with all rounding bounded (of G*, where only that was given). O(ngc^3).
  bool proven_positive_definite() const;

  /// x := G* x, for ngc entries.
  void solve(QuadVector& x) const;

  /// x := G* x for an x with entries only in the rows of `pattern`; `pattern` becomes the rows of the result.
  /// Costs the blocks that are touched, not ngc.
  void solve(QuadVector& x, std::vector<std::size_t>& pattern) const;

  /// How far solve() may be off, entry by entry: a bound to first order in the rounding of 113 bits. Zero for blocks that
  /// are proven far from singular, and for a given G*. It grows with the cube of the inverse of the
  /// distance by which the least independent of the factors is outside the span of the others.
  QuadVector solve_error(const QuadVector& x) const;
  /// Whether solve_error() may be other than zero.
  bool has_reduced_rank() const;

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
    bool is_inverse = false;
    std::optional<QuadMatrix> range;    ///< size x rank, orthonormal; empty when the rank is full
    std::optional<QuadMatrix> columns;  ///< independent factors, scaled to unit length
    QuadVector weights;                 ///< alpha_k |x_k|^2, so that G = columns diag(weights) columns'
    QuadCholesky factor;                ///< of G, or of columns'columns, or of range' G range
    Quad tilt = 0;                      ///< bound on the sine of the angle between `range` and the range of G
    Quad formed = 0;                    ///< in whose terms range' G range is rounded: zero where it is not formed
    Quad spread = 0;                    ///< the same of the rows of range' W, G = W W': zero where these are not factored
    bool is_by_rows = false;            ///< of full rank, by the rows of W: these may be all but dependent

    std::size_t size() const { return matrix.rows; }
    void solve(Quad* x) const;
    QuadVector solve_error(const Quad* x) const;
    QuadVector error_by_columns(const Quad* x) const;
    QuadVector error_by_range(const QuadMatrix& B, const Quad* x) const;
  };

  void add_inertia(const Matrix& G);
  void add_factors(const FactoredInertia& factors);
  void add_inverse(const Matrix& Ginv);
  void find_range(Block& block, const QuadMatrix& W);
  void find_range(Block& block);
  void cut(Block& block);
  static bool factor_regular(Block& block, std::size_t formation_terms);
  static bool factor_independent(Block& block, const QuadMatrix& X, const QuadVector& alpha);
  void add(Block block);

  std::vector<Block> blocks_;
  std::vector<std::size_t> block_of_row_;
  std::size_t dimension_ = 0;
  bool well_defined_ = true;
  bool has_inertia_ = true;
  bool unresolved_ = false;
  bool is_cut_ = false;
};

}  // namespace lcpbench
