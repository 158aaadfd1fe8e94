#pragma once

#include <vector>

#include "core/contact_problem.h"
#include "core/islands.h"
#include "study/evaluation/bounded.h"

namespace lcpbench {

/// What QuadInertia is, in Bounded arithmetic and for the inertias that it suits: a given inverse, and blocks proven
/// positive definite far from singular, of which QuadInertia makes the same G*. Others are not well_defined() here.
///
/// G x = b is solved with an approximate inverse R in double: x grows by R times the residual, which is formed in sums
/// of two doubles, until its error stays. With |I - R G| <= contraction < 1 in the maximum norm the error left is
/// bounded by the last residual. A dense G is taken apart into the blocks that its zeros leave. [Rump 2010,
/// "Verification methods", Acta Numerica 19]
class BoundedInertia {
 public:
  explicit BoundedInertia(const Inertia& inertia);

  bool well_defined() const { return well_defined_; }
  /// False when only G* was given.
  bool has_inertia() const { return has_inertia_; }
  /// Of well_defined() inertia. A given inverse is not looked at.
  bool proven_positive_definite() const { return has_inertia_; }

  /// x := G* x, for ngc entries.
  void solve(BoundedVector& x) const;
  /// x := G* x for an x with entries only in the rows of `pattern`, which becomes the rows of the result.
  void solve(BoundedVector& x, std::vector<std::size_t>& pattern) const;
  /// The same in double. Returns a bound on the error of any entry, which may be infinite.
  double estimate(std::vector<double>& x, std::vector<std::size_t>& pattern) const;
  /// G x.
  BoundedVector apply(const BoundedVector& x) const;
  /// |G| x for x >= 0; |G*| x where only that was given.
  BoundedVector scale(const BoundedVector& x) const;

 private:
  /// Of coordinates that are scaled by powers of two, so that a block of G has diagonal entries from 1 to 4.
  struct Block {
    std::vector<std::size_t> coordinates;
    std::vector<double> units;  ///< a coordinate is its unit times the scaled one
    Matrix matrix;              ///< the scaled G; the given G*
    Matrix approximate;         ///< R; empty until it is needed
    double contraction = 0;     ///< bound of |I - R G| in the maximum norm

    Index size() const { return matrix.rows(); }
  };
  void add_inertia(const Matrix& G, std::size_t offset);
  void reserve(Index ngc);
  void add_single(double inertia, std::size_t row);
  static bool scale_and_prove(Block& block, const Matrix& G);
  static void invert(Block& block);
  void solve(Block& block, BoundedVector& x) const;
  static void multiply(const Block& block, bool magnitudes, const BoundedVector& x, BoundedVector& y);
  BoundedVector product(const BoundedVector& x, bool magnitudes) const;
  void divide(std::size_t row, BoundedVector& x) const;
  double estimate(Block& block, std::vector<double>& x) const;
  /// Replaces the rows of a pattern by those that G* couples them to, and lists their blocks in touched_.
  void couple(std::vector<std::size_t>& pattern) const;

  std::vector<double> singles_;        ///< per coordinate: its inertia where it is coupled to no other, else 0
  mutable std::vector<Block> blocks_;  ///< of the others
  std::vector<std::size_t> block_of_row_;
  RowIslands parts_;  ///< scratch of add_inertia()
  std::vector<Index> queue_;
  mutable std::vector<double> refinement_;    ///< scratch of solve()
  mutable std::vector<std::size_t> touched_;  ///< by couple()
  bool well_defined_ = true;
  bool has_inertia_ = true;
};

}  // namespace lcpbench
