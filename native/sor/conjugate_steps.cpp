#include "native/sor/conjugate_steps.h"

#include <algorithm>

namespace lcpbench {
namespace {

void copy(std::span<const Entries> ranges, const Vector& from, Vector& to) {
  for (const Entries& range : ranges) std::copy_n(from.data() + range.first, range.size, to.data() + range.first);
}

void set_zero(std::span<const Entries> ranges, Vector& x) {
  for (const Entries& range : ranges) std::fill_n(x.data() + range.first, range.size, 0.0);
}

/// The step along the last direction, and the next direction.
void extrapolate(std::span<const Entries> ranges, double share, Vector& before, Vector& direction, Vector& now) {
  for (const Entries& range : ranges) {
    auto x = now.segment(range.first, range.size).array();
    auto d = direction.segment(range.first, range.size).array();
    auto x_before = before.segment(range.first, range.size).array();
    for (Index i = 0; i < range.size; ++i) {
      const double step = x(i) - x_before(i);
      const double along = share * d(i);
      x(i) += along;
      d(i) = along + step;
      x_before(i) = x(i);
    }
  }
}

}  // namespace

void ConjugateSteps::load(Index rows, Index coordinates) {
  x_before_.resize(rows);
  x_direction_.resize(rows);
  u_before_.resize(coordinates);
  u_direction_.resize(coordinates);
}

void ConjugateSteps::begin(const Part& part, const Vector& x, const Vector& u) {
  set_zero(part.x, x_direction_);
  set_zero(part.u, u_direction_);
  copy(part.x, x, x_before_);
  copy(part.u, u, u_before_);
  size_ = 0;
}

void ConjugateSteps::after_sweep(const Part& part, double size, Vector& x, Vector& u) {
  const bool is_first = size_ == 0;
  const double share = size < size_ ? size / size_ : 0.0;
  if (share == 0 && !is_first) {
    begin(part, x, u);
  } else {
    extrapolate(part.x, share, x_before_, x_direction_, x);
    extrapolate(part.u, share, u_before_, u_direction_, u);
  }
  size_ = size;
}

}  // namespace lcpbench
