#pragma once

#include <span>

#include "core/types.h"

namespace lcpbench {

/// Consecutive entries of a vector.
struct Entries {
  Index first = 0;
  Index size = 0;
};

/// Steps along conjugate directions between sweeps: the nonlinear conjugate gradient method of Fletcher and Reeves,
/// with the step of a sweep in place of the negative gradient. After a sweep, x moves on by beta d: d is the last
/// direction, zero at first, and beta the ratio of this sweep's `size` to that of the one before. The next direction is
/// the step of the sweep plus beta d. Where beta >= 1, x does not move on, and the method starts anew with the next
/// sweep.
///
/// u depends on x by an affine map, so that the same steps keep it the velocity of x. x may leave its bounds; the next
/// sweep projects it back. Each call takes O(entries of the part); none but load() allocates.
/// [Silcowitz, Niebe, Erleben 2010, A nonsmooth nonlinear conjugate gradient method for interactive contact force
/// problems]
class ConjugateSteps {
 public:
  /// What the sweeps change: ranges of impulses x and of velocities u.
  struct Part {
    std::span<const Entries> x;
    std::span<const Entries> u;
  };

  /// Takes the memory for x of `rows` and u of `coordinates` entries. begin() has to follow.
  void load(Index rows, Index coordinates);
  /// Starts anew within the part, from x and u before its first sweep. One part at a time.
  void begin(const Part& part, const Vector& x, const Vector& u);
  /// @param size  of the sweep's step: the sum of its squares, each weighted by its curvature
  /// @param x, u  after the sweep; on return, from where the next sweep starts
  void after_sweep(const Part& part, double size, Vector& x, Vector& u);

 private:
  Vector x_before_, x_direction_;
  Vector u_before_, u_direction_;
  double size_ = 0;  // of the last sweep's step
};

}  // namespace lcpbench
