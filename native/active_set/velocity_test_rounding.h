#pragma once

// How far rounding may have moved the velocities that VelocityTest judges.

#include "native/active_set/velocity_test.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

inline bool VelocityTest::covers_rounding(const Answer& answer, Scalar most, Scalar moved) const {
  if (!condition_is_trusted()) return false;
  const Scalar of_change = answer.velocity != nullptr ? of_velocity(answer) : of_whitened_change();
  const Scalar sums = roundings(4 * static_cast<double>(whitening_.ngc()));
  const Scalar of_terms = sums * sums * size() * whitening_.condition() * moved;
  return most * most > static_cast<Scalar>(kSafeSquare) && of_change > 0 &&
         static_cast<Scalar>(1.1) * whitening_.largest_squared_norm() * of_change + 11 * of_terms <= most * most;
}

inline double VelocityTest::of_velocity(const Answer& answer) const {
  const Scalar condition = whitening_.condition();
  const Scalar roundoff = (size() + 3) * static_cast<Scalar>(kUnitRoundoff<Scalar>);
  const auto of_difference = L::broadcast(22 * condition);
  const auto of_rounding = L::broadcast(44 * condition * size() * roundoff * roundoff);
  const auto of_change = L::broadcast(static_cast<Scalar>(1.1));
  auto sum = L::broadcast(0);
  for (Count i = 0; i < lanes(); i += L::kWidth) {
    const auto root = L::load(whitening_.root_diagonal() + i);
    const auto from = root * L::load(answer.v + i);
    const auto to = root * L::load(answer.velocity + i);
    const auto off = L::load(change_.data() + i) - L::load(answer.whitened_change + i);
    const auto change = to - from;
    sum += of_change * change * change + of_difference * off * off + of_rounding * (to * to + from * from);
  }
  const Scalar squared = L::sum(sum);
  const Scalar error = size() * whitening_.backward_error();
  return squared > static_cast<Scalar>(kSafeSquare) ? condition * error * error * squared : Scalar(0);
}

inline void VelocityTest::add_row(const Answer& answer, Count j, ContactScale<Scalar>& scale) const {
  Scalar velocity = 0, terms = 0;
  Count entries = 0;
  for (Count i = 0; i < whitening_.ngc(); ++i) {
    const double entry = whitening_.given_normal(j)[i];
    const Scalar part = static_cast<Scalar>(entry) * answer.v[i];
    entries += entry != 0 ? 1 : 0;
    velocity += part;
    terms += magnitude(part);
  }
  scale.add_row(velocity, terms, static_cast<double>(entries));
}

inline double VelocityTest::rounding(const Measure& island) const {
  if (!(island.terms > 0)) return island.terms == 0 ? Scalar(0) : kInfinity<Scalar>;
  const Scalar reach = square_root(island.largest);
  const Scalar sums = roundings(static_cast<double>(whitening_.ngc() + pressed_));
  if (!whitening_.triangular()) return reach * island.terms * (2 * whitening_.noise() + sums);
  if (!condition_is_trusted()) return kInfinity<Scalar>;
  return reach * square_root(whitening_.condition()) *
         (size() * whitening_.backward_error() * square_root(island.squared_change) +
          sums * square_root(size()) * island.terms);
}

inline double VelocityTest::rounding(const Measure& island, Count j) const {
  if (!(island.terms > 0)) return island.terms == 0 ? Scalar(0) : kInfinity<Scalar>;
  if (!condition_is_trusted()) return kInfinity<Scalar>;
  const Scalar off = off_by(island.squared_residual, island.squared_change, island.terms);
  return square_root(whitening_.squared_norm(j)) * off + roundings(static_cast<double>(whitening_.ngc())) * terms_[j];
}

inline void VelocityTest::measure_residual(const Answer& answer) {
  form_residual(answer, change_.data());
  for (Count k = 0; k < islands_; ++k) measures_[k].squared_residual = 0;
  for (Count i = 0; i < whitening_.ngc(); ++i) {
    const Count k = island_of_coordinate_ == nullptr ? 0 : island_of_coordinate_[i];
    if (k >= 0) measures_[k].squared_residual += residual_[i] * residual_[i];
  }
}

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
