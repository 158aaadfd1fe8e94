#pragma once

#include <span>

#include "core/types.h"

namespace lcpbench {

/// Consecutive entries of a vector.
struct Entries {
  Index first = 0;
  Index size = 0;
};

/// Steps along conjugate directions between sweeps, as in the nonlinear conjugate gradient method of Fletcher and
/// Reeves with the step of a sweep in place of the gradient. A sweep that moves more than the one before forgets the
/// directions, its own step included.
/// [Silcowitz, Niebe, Erleben 2010, A nonsmooth nonlinear conjugate gradient method for interactive contact force
/// problems]
class ConjugateSteps {
 public:
  /// What the sweeps change: ranges of impulses x and of velocities u.
  struct Part {
    std::span<const Entries> x;
    std::span<const Entries> u;
  };

  /// Takes the memory for x and u.
  void load(Index rows, Index coordinates);
  /// Forgets all directions within the part, and remembers x and u before its first sweep.
  void begin(const Part& part, const Vector& x, const Vector& u);
  /// @param size of the sweep's step: the sum of its squares, each weighted by its curvature @param x, u after a sweep;
  ///     on return before the next one
  void after_sweep(const Part& part, double size, Vector& x, Vector& u);

 private:
  Vector x_before_, x_direction_;
  Vector u_before_, u_direction_;
  double size_ = 0;  // of the last sweep's step
};

}  // namespace lcpbench
