#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/contact_problem.h"
#include "core/quad_inertia.h"

namespace lcpbench {

/// G and G* of a contact problem as QuadInertia defines them, at the price of factors in double.
///
/// A given G is split into its connected blocks, each scaled by powers of two and factored in double. Solutions are
/// refined with residuals in 113 bits, over the nonzeros of G, until the next correction would be below 2^-104 of them.
/// Where a pivot is small, where a refinement does not converge, and for an inertia by factors, QuadInertia takes over.
/// A given G* is one matrix to multiply by.
/// A block of k coordinates costs O(k^3) operations in double once. One thread at a time: const members share scratch.
class RefinedInertia {
 public:
  /// @param inertia  must outlive this object
  explicit RefinedInertia(const Inertia& inertia);

  /// False where no G* could be made of the data: see QuadInertia.
  bool well_defined() const { return precise_ ? precise_->well_defined() : finite_; }
  bool unresolved() const { return precise_ && precise_->unresolved(); }
  /// Whether the range of G* is not that of G: see QuadInertia.
  bool is_cut() const { return precise_ && precise_->is_cut(); }
  /// False when only G* was given.
  bool has_inertia() const { return has_inertia_; }
  /// By a factorization in double with all rounding bounded, or else in 113 bits. [Rump 2006]
  bool proven_positive_definite() const;

  /// x := G* x, for ngc entries. NaN where that turns out not to be well-defined.
  void solve(QuadVector& x) const;
  /// J'G* J for the column J with these entries in `rows`, to about 2^-30 of it.
  Quad energy(std::span<const std::size_t> rows, const double* entries) const;
  /// G* J for the column J with these entries in `rows`, in 113 bits: visit(i, entry) for the rows that may not be zero.
  template <class Visit>
  void for_each_response(std::span<const std::size_t> rows, const double* entries, Visit&& visit) const {
    respond(rows, entries);
    for (const std::size_t i : pattern_) visit(i, wide_[i]);
    for (const std::size_t i : pattern_) wide_[i] = 0;
  }
  /// Column `coordinate` of G*, to about 2^-30: visit(i, G*_i) for the rows that may not be zero.
  template <class Visit>
  void for_each_inverse(std::size_t coordinate, Visit&& visit) const {
    const double one = 1;
    if (solve_roughly({&coordinate, 1}, &one)) {
      for (const std::size_t i : pattern_) visit(i, Quad{rough_[i]});
      return;
    }
    solve_precisely({&coordinate, 1}, &one);  // entries may be beyond the range of a double
    for (const std::size_t i : pattern_) visit(i, wide_[i]);
  }

  /// G x; G* x where only that was given. |G| x or |G*| x with `magnitudes`. Number is Quad, or double where
  /// is_moderate().
  template <class Number>
  std::vector<Number> apply(const std::vector<Number>& x, bool magnitudes = false) const;
  /// x less its orthogonal projection on the range of G: zero when G has full rank or is unknown.
  QuadVector outside_range(const QuadVector& x) const {
    return precise_ ? precise_->outside_range(x) : QuadVector(x.size(), 0);
  }
  /// How far solve() may be off, entry by entry: see QuadInertia. Empty: by no more than 113 bits round.
  QuadVector solve_error(const QuadVector& x) const { return has_error() ? precise_->solve_error(x) : QuadVector(); }
  bool has_error() const { return precise_ && precise_->has_reduced_rank(); }
  /// Whether double has the range for products with the inertia.
  bool is_moderate() const { return !precise_; }

 private:
  /// Coordinates that the inertia couples. Those of a block follow each other in coordinates_.
  struct Block {
    std::size_t first = 0;
    std::size_t size = 0;
    bool rough = false;  ///< its solutions in double are worse than 2^-30
  };
  /// Sparse columns, of which the number of the first in a block is its `first`.
  struct Columns {
    std::vector<std::size_t> begin{0};
    std::vector<std::size_t> rows;  ///< in the block
    std::vector<double> values;
  };

  void add(const Matrix& given, std::size_t offset);
  bool factor(Block& block);
  bool eliminate(const Block& block, double shift, Columns& U, std::vector<double>& pivots) const;
  void solve_in_double(const Block& block, double* x) const;
  bool refine(const Block& block, QuadVector& x) const;
  void make_precise() const;
  void load(std::span<const std::size_t> rows, const double* entries) const;
  bool solve_roughly(std::span<const std::size_t> rows, const double* entries) const;
  void solve_precisely(std::span<const std::size_t> rows, const double* entries) const;
  void respond(std::span<const std::size_t> rows, const double* entries) const;
  void find_touched(std::span<const std::size_t> rows) const;

  const Inertia& inertia_;
  bool has_inertia_ = true;
  bool finite_ = true;
  std::vector<Block> blocks_;
  std::vector<std::size_t> coordinates_;
  std::vector<std::size_t> block_of_;  ///< of each coordinate
  Columns given_;                      ///< G, or the given G*
  std::vector<double> units_;          ///< u_i, in the order of coordinates_: the scaled entry is u_i G_ij u_j
  Columns U_;                          ///< U D U' is the scaled block; the columns of a block from the last one on
  std::vector<double> pivots_;         ///< D, in the order of U_
  mutable std::optional<QuadInertia> precise_;
  mutable QuadVector solved_, solution_, residual_, wide_;   ///< wide_: zeros, but for pattern_ where precise_ is there
  mutable std::vector<double> correction_, rough_;  ///< rough_: zeros but for pattern_
  mutable std::vector<std::size_t> pattern_, touched_;
};

}  // namespace lcpbench
