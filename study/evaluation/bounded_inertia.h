#pragma once

#include <memory_resource>
#include <span>
#include <vector>

#include "core/contact_problem.h"
#include "core/islands.h"
#include "study/evaluation/bounded.h"
#include "study/evaluation/bounded_factors.h"

namespace lcpbench {

/// G and G* as QuadInertia has them, in Bounded arithmetic, for a finite given G* and for a given G that is proven
/// positive definite and far from singular. Other inertias, and those by factors, are not well_defined() here.
///
/// G x = b is solved by factors in double with iterative refinement, whose residuals are formed in sums of two doubles.
/// BoundedFactors bounds the remaining error. A given G, or each of its given blocks, is split into its connected
/// blocks; a given G* is one block. A block of k coordinates costs O(k^3) once and O(k^2) for each product or solution.
/// One thread at a time: the const members share scratch. [Rump 2010, "Verification methods", Acta Numerica 19]
class BoundedInertia {
 public:
  /// @param memory  must outlive this object.
  explicit BoundedInertia(const Inertia& inertia, std::pmr::memory_resource* memory = std::pmr::get_default_resource());

  /// All members below expect this.
  bool well_defined() const { return well_defined_; }
  /// False when only G* was given.
  bool has_inertia() const { return has_inertia_; }
  /// A given inverse is not looked at.
  bool proven_positive_definite() const { return has_inertia_; }

  /// x := G* x, for ngc entries.
  void solve(BoundedVector& x) const;
  /// The same for an x with nonzero entries only in the rows of `pattern`, each listed once; `pattern` becomes the rows
  /// of the result. By a given inertia it costs only the blocks that are touched.
  void solve(BoundedVector& x, std::vector<std::size_t>& pattern) const;
  /// A lower bound of x'G* x for the x with these entries in `rows` and zeros elsewhere, from G's diagonal alone, in
  /// O(rows): about x_i^2 / G_ii of any row i, or more. 0 where only G* was given.
  double least_energy(std::span<const std::size_t> rows, const double* entries) const;
  /// G x; G* x where only that was given.
  BoundedVector apply(const BoundedVector& x) const;
  /// The same, with blocks multiplied in double: faster, with wider error bounds.
  BoundedVector apply_in_double(const BoundedVector& x) const;
  /// |G| x for x >= 0; |G*| x where only that was given. By products in double: no sum of magnitudes cancels.
  BoundedVector scale(const BoundedVector& x) const;

 private:
  /// A block of G, scaled from both sides by powers of two to diagonal entries in [1, 4), or the whole given G*.
  struct Block {
    std::size_t first = 0;  ///< where its coordinates begin in coordinates_
    std::size_t size = 0;
    std::size_t entries = 0;  ///< where its matrix, by columns, begins in entries_
  };
  std::span<const std::size_t> coordinates(const Block& block) const {
    return std::span(coordinates_).subspan(block.first, block.size);
  }
  const double* column(const Block& block, std::size_t j) const {
    return entries_.data() + block.entries + j * block.size;
  }
  void add_inertia(const Matrix& G, std::size_t offset);
  void add_inverse(const Matrix& Ginv);
  void reserve(Index ngc);
  void add_single(double inertia, std::size_t row);
  bool add_block(const Matrix& G, std::size_t offset, std::size_t first);
  void solve(std::size_t b, BoundedVector& x) const;
  void multiply(const Block& block, const BoundedVector& x, BoundedVector& y) const;
  void multiply_in_double(const Block& block, bool magnitudes, const BoundedVector& x, BoundedVector& y) const;
  BoundedVector product_with_singles(const BoundedVector& x) const;
  void divide(std::size_t row, BoundedVector& x) const;
  /// Replaces the rows of a pattern by those that G* couples them to, and lists their blocks in touched_.
  void couple(std::vector<std::size_t>& pattern) const;

  std::pmr::vector<double> singles_;  ///< per coordinate: its inertia where it is coupled to no other, else 0
  std::pmr::vector<double> inverse_diagonal_;  ///< per coordinate: 1 / G_ii in double; 0 where only G* was given
  std::pmr::vector<double> units_;  ///< per coordinate u_i: a block's scaled entry is u_i G_ij u_j
  std::pmr::vector<Block> blocks_;  ///< of the coordinates that singles_ leaves out
  std::pmr::vector<std::size_t> coordinates_;
  std::pmr::vector<double> entries_;
  BoundedFactors factors_;  ///< of each block
  std::pmr::vector<std::size_t> block_of_row_;
  RowIslands parts_;  ///< scratch of add_inertia()
  std::vector<Index> queue_;
  mutable std::vector<double> refinement_;    ///< scratch of solve() and multiply_in_double()
  mutable std::vector<std::size_t> touched_;  ///< result of couple()
  mutable std::vector<BoundedSum> sums_;      ///< scratch of multiply()
  bool well_defined_ = true;
  bool has_inertia_ = true;
};

}  // namespace lcpbench
