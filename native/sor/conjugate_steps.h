#pragma once

#include "core/types.h"

namespace lcpbench {

/// Steps along conjugate directions between sweeps: the nonlinear conjugate gradient method of Fletcher and Reeves,
/// with the step of a sweep in place of the negative gradient. After a sweep, x moves on by beta d: d is the last
/// direction, zero at first, and beta the ratio of this sweep's `size` to that of the one before. The next direction is
/// the step of the sweep plus beta d. Where beta >= 1, x does not move on, and the method starts anew with the next
/// sweep.
///
/// u depends on x by an affine map, so that the same steps keep it the velocity of x. x may leave its bounds; the next
/// sweep projects it back. Each call takes O(entries); none but load() allocates.
/// [Silcowitz, Niebe, Erleben 2010, A nonsmooth nonlinear conjugate gradient method for interactive contact force
/// problems]
class ConjugateSteps {
 public:
  /// Takes the memory for x of `rows` and u of `coordinates` entries. begin() has to follow.
  void load(Index rows, Index coordinates) {
    x_.load(rows);
    u_.load(coordinates);
  }

  /// Starts anew, from x and u before the first sweep.
  void begin(const Vector& x, const Vector& u) {
    x_.begin(x);
    u_.begin(u);
    size_ = 0;
  }

  /// @param size  of the sweep's step: the sum of its squares, each weighted by its curvature
  /// @param x, u  after the sweep; on return, from where the next sweep starts
  void after_sweep(double size, Vector& x, Vector& u) {
    const bool is_first = size_ == 0;
    const double share = size < size_ ? size / size_ : 0.0;
    if (share == 0 && !is_first) {
      begin(x, u);
    } else {
      x_.step(share, x);
      u_.step(share, u);
    }
    size_ = size;
  }

 private:
  struct Path {
    Vector before, direction;

    void load(Index size) {
      before.resize(size);
      direction.resize(size);
    }
    void begin(const Vector& now) {
      before = now;
      direction.setZero();
    }
    void step(double share, Vector& now) {
      for (Index i = 0; i < now.size(); ++i) {
        const double swept = now(i) - before(i);
        const double along = share * direction(i);
        now(i) += along;
        direction(i) = along + swept;
        before(i) = now(i);
      }
    }
  };

  Path x_, u_;
  double size_ = 0;  // of the last sweep's step
};

}  // namespace lcpbench
