#pragma once

#include <vector>

#include "core/lcp.h"
#include "core/quad.h"

namespace lcpbench {

/// Row-norm backward error that the evaluation allows of bare LCPs. The test bounds its own rounding.
inline constexpr double kClaimedBackwardError = 1e-9;

/// Tests answers to a bare LCP from its data: whether they solve it as the verdict has it, and whether what almost
/// solves it proves that nothing does. Memory: n^2 doubles, touched only where the latter is asked for.
class BareLcpTest {
 public:
  /// @param lcp must stay as it is until the next load. O(n^2)
  void load(const Lcp& lcp);

  /// Bound on the largest violation |w_i| (z_i > 0) or max(0, -w_i) relative to |q_i| + norm_1(M_i) max z, the rounding
  /// of w included; infinity for z of other length, negative or not finite. Rows whose numbers double may not hold are
  /// evaluated in 113 bits. O(n^2), allocates nothing.
  double backward_error(const Vector& z);

  /// Whether the z that backward_error() saw last, though small in it, belongs to a problem without any solution: it
  /// violates w >= 0, if only by rounding, and its basis, or that without the violated row, gives u >= 0 with M'u <= 0
  /// and q'u < 0 (in 113 bits, in which the products are exact). Random data hide such a u in rounding; what is not
  /// proven may still be unsolvable. O(n support + support^3) where w >= 0 is violated, else O(n). Allocates nothing.
  bool disproves(const Vector& z);

  /// That u, n entries. @pre disproves() was true
  const Vector& proof() const { return u_; }

  /// Whether u >= 0, M'u <= 0 and q'u < 0, where n `unit` of the magnitudes of their terms counts as the rounding of a
  /// sum. False for u of another length or not finite. O(n^2) in 113 bits
  bool proves(const Vector& u, Quad unit) const;

 private:
  double row_error(Index row, const Vector& z, double largest) const;
  double row_error_in_quad(Index row, const Vector& z) const;
  Index worst_violated(const Vector& z) const;
  bool find_witness(Index violated, const Vector& z);
  bool solve_block(Index order);

  const Lcp* lcp_ = nullptr;
  Vector row_norm_, w_;         // n
  std::vector<Index> support_;  // n reserved
  Matrix block_;                // n x n, touched on demand
  Vector u_, weights_;          // n
};

}  // namespace lcpbench
