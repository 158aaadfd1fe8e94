#pragma once

#include <vector>

#include "core/lcp.h"
#include "core/quad.h"
#include "native/proofs/farkas_search.h"

namespace lcpbench {

/// Backward error (see lcp_error()) up to which an answer to a bare LCP is claimed: half of the verdict's 1e-6.
inline constexpr double kClaimedBackwardError = 5e-7;

/// Tests answers to a bare LCP from its data: whether they solve it as the verdict has it, and whether what almost
/// solves it has no solution at all. Memory: n^2 doubles, and more up to FarkasSearch::kLargestQuad, touched only where
/// the latter is asked for.
class BareLcpTest {
 public:
  /// @param lcp must stay as it is until the next load. O(n^2)
  void load(const Lcp& lcp);

  /// Bound on the backward error, see lcp_error(), rounding included. Infinity for z of other length, negative or not
  /// finite. Rows whose numbers double may not hold are evaluated in 113 bits. O(n^2), allocates nothing.
  double backward_error(const Vector& z);

  /// Whether the problem that the z of the last backward_error() seems to solve is proven exactly to have no solution,
  /// by a vector u >= 0 with M'u <= 0 and q'u < 0 in doubles. Asked for only where z, with zeros where w does not
  /// vanish, violates w >= 0 exactly, and its basis does not clearly give a solution. What is not proven may still be
  /// unsolvable. Allocates nothing.
  /// @param deadline_s on wall_clock_s()
  bool disproves(const Vector& answer, double deadline_s);

  /// The same without any z, such as after a ray of Lemke's method.
  bool disproves(double deadline_s);

  /// The same by rounding u, which proves it nearly, and else as above.
  bool disproves_near(const Vector& u, double deadline_s);

  /// That u, n entries. @pre the last disproves() was true
  const Vector& proof() const { return search_.proof(); }

 private:
  void evaluate(const Vector& z);
  double scale(Index row) const;
  double row_error(Index row, const Vector& z) const;
  double row_error_in_quad(Index row, const Vector& z) const;
  void find_basis(const Vector& z);
  bool has_clear_basis(const Vector& z);
  int sign_of_w(Index row, const Vector& z) const;

  const Lcp* lcp_ = nullptr;
  std::vector<Quad> norm_;         // n: c_i
  std::vector<Quad> least_scale_;  // n: the share of F_i
  Vector w_, terms_, basis_;       // n; of the last z that was evaluated: w, and the sums of the magnitudes of its terms
  std::vector<Index> support_;     // n reserved
  std::vector<char> candidates_;   // n
  FarkasSearch search_;
};

}  // namespace lcpbench
