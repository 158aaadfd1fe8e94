// The end of ConeIsland::solve: from impulses near a solution to one.

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/timed_solve.h"
#include "native/cone_ipm/cone_island.h"

namespace lcpbench {

/// x = the projection of x_held_ - step (u + R x) onto normal impulses >= 0 and the disc of radius x_0, and the weights
/// that are the derivative by -u.
void ConeIsland::press(double weight) {
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Contact& contact = contacts_[c];
    const Index row = contact.row;
    const double diagonal = contact.diagonal_normal / (contact.scale() * contact.scale());
    Eigen::Matrix3d& derivative = scalings_[c].weight;
    derivative.setZero();
    // x = held - step (u + R x) is (held - step u) / (1 + step R), and its projection on the disc is that of x.
    double step = diagonal > 0 ? weight / diagonal : 0.0;
    const double give = 1 + step * contact.compliance(0);
    const double pressed = (x_held_(row) - step * u_(row)) / give;
    step /= give;
    x_(row) = std::max(pressed, 0.0);
    if (pressed > 0) derivative(0, 0) = step;
    if (contact.rows == 1) continue;
    double step_tangent = contact.diagonal_tangent > 0 ? weight / contact.diagonal_tangent : 0.0;
    const double give_tangent = 1 + step_tangent * contact.compliance(1);
    const Eigen::Vector2d aim =
        (x_held_.segment<2>(row + 1) - step_tangent * u_.segment<2>(row + 1)) / give_tangent;
    step_tangent /= give_tangent;
    if (is_relaxed_) {
      press_on_cone(c, {pressed, aim(0), aim(1)}, {step, step_tangent, step_tangent});
      continue;
    }
    const double length = aim.norm();
    if (length <= x_(row)) {
      x_.segment<2>(row + 1) = aim;
      derivative(1, 1) = derivative(2, 2) = step_tangent;
      continue;
    }
    const Eigen::Vector2d direction = aim / length;
    const double share = x_(row) / length;
    x_.segment<2>(row + 1) = x_(row) * direction;
    derivative.block<2, 2>(1, 1) =
        share * step_tangent * (Eigen::Matrix2d::Identity() - direction * direction.transpose());
    if (pressed > 0) derivative.block<2, 1>(1, 0) = step * direction;
  }
}

/// The same for the relaxation: the point of the cone |x_t| <= x_0 nearest to `pressed` in the norm of 1 / step.
/// In coordinates x / sqrt(step) that norm is Euclid's, and the cone |x_t| <= slope x_0.
void ConeIsland::press_on_cone(std::size_t index, const Eigen::Vector3d& pressed, const Eigen::Vector3d& step) {
  const Index row = contacts_[index].row;
  Eigen::Matrix3d& derivative = scalings_[index].weight;
  const double slope = std::sqrt(step(0) / step(1));
  const Eigen::Vector3d root = step.cwiseSqrt(), a = pressed.cwiseQuotient(root);
  const double length = a.tail<2>().norm();
  derivative.setZero();
  if (length <= slope * a(0)) {
    x_.segment<3>(row) = pressed;
    derivative.diagonal() = step;
  } else if (slope * length <= -a(0)) {
    x_.segment<3>(row).setZero();
  } else {
    const double height = (a(0) + slope * length) / (1 + slope * slope);
    const Eigen::Vector2d direction = a.tail<2>() / length;
    const Eigen::Vector3d ray(1, slope * direction(0), slope * direction(1));
    x_.segment<3>(row) = height * root.cwiseProduct(ray);
    derivative = ray * ray.transpose() / (1 + slope * slope);
    derivative.bottomRightCorner<2, 2>() +=
        slope * height / length * (Eigen::Matrix2d::Identity() - direction * direction.transpose());
    derivative = (root.asDiagonal() * derivative * root.asDiagonal()).eval();
  }
}

/// w = A'x(w) by Newton's method, until rounding or `most_steps` ends it. @returns false at a limit,
/// or where the numbers fail.
bool ConeIsland::settle_multipliers(double weight, int most_steps, const ConeLimits& limits, Counters& counters) {
  constexpr double kConverged = 1e-13;
  constexpr double kNear = 1e-9;  // where a step that does not halve the rest is one of rounding
  double last = std::numeric_limits<double>::infinity();
  for (int step = 0; step < most_steps; ++step) {
    take_rigid_velocity();
    press(weight);
    combine(x_, dw_);
    dw_ -= w_;
    const double off = dw_.lpNorm<Eigen::Infinity>();
    const double size = w_.lpNorm<Eigen::Infinity>();
    if (off <= kConverged * size || (off <= kNear * size && !(off <= last / 2))) break;
    last = off;
    if (!std::isfinite(off) || !(wall_clock_s() < limits.deadline_s)) return false;
    if (counters.iterations >= limits.max_iterations || !factor()) return false;
    ++counters.iterations;
    ++counters.factorizations;
    lu_.solve(dw_);
    w_ += dw_;
  }
  take_rigid_velocity();
  press(weight);
  return x_.allFinite();
}

/// From the best impulses: the method of multipliers on the conditions themselves. It needs neither an interior nor
/// strict complementarity, and the impulses of redundant contacts stay near where they are. What would be accepted is
/// improved as long as each round halves the residual.
void ConeIsland::finish(const ConeLimits& limits, Counters& counters) {
  constexpr int kRounds = 12;
  constexpr int kFewestRounds = 3;
  constexpr int kSteps = 12;
  // Where the energy of the relaxation is within a gap of the least one, the velocity is within its root.
  const double tolerance = is_relaxed_ ? 0 : limits.tolerance;
  for (const double weight : {1e4, 1e6}) {
    x_held_ = best_x_;
    combine(x_held_, w_);
    for (int round = 0; round < kRounds && !(best_residual_ <= tolerance); ++round) {
      if (!settle_multipliers(weight, kSteps, limits, counters)) break;
      combine(x_, w_);
      take_velocity();
      const double before = best_residual_;
      keep_best();
      x_held_ = x_;
      if (round >= kFewestRounds && !(best_residual_ < before)) break;
      if (best_residual_ <= limits.accepted && !(best_residual_ <= before / 2)) return;
    }
  }
}

/// From the best impulses, as finish(), but with a weight that grows and few Newton steps a round, and given up after
/// the first round that gains less than a factor of four. Where it converges it takes fewer factorizations than the
/// interior point. @returns whether the residual is within the tolerance; the best impulses are kept in any case
bool ConeIsland::try_multipliers(double first_weight, const ConeLimits& limits, Counters& counters) {
  constexpr double kGrowth = 4;
  constexpr int kSteps = 3;
  constexpr double kProgress = 0.25;
  x_held_ = best_x_;
  combine(x_held_, w_);
  for (double weight = first_weight; !(best_residual_ <= limits.tolerance); weight *= kGrowth) {
    const double before = best_residual_;
    if (!settle_multipliers(weight, kSteps, limits, counters)) return false;
    combine(x_, w_);
    take_velocity();
    keep_best();
    if (!(best_residual_ <= kProgress * before)) return false;
    x_held_ = x_;
  }
  return true;
}

/// Takes the impulses away of contacts that separate faster than their impulse would stop: an interior point has some
/// of every contact's.
void ConeIsland::drop_separating(const ConeLimits& limits) {
  constexpr double kMostLoss = 10;
  x_ = best_x_;
  combine(x_, w_);
  take_velocity();
  for (const Contact& contact : contacts_) {
    const double scale = contact.scale();
    if (contact.diagonal_normal * x_(contact.row) >= scale * scale * u_(contact.row)) continue;
    x_.segment(contact.row, contact.rows).setZero();
  }
  combine(x_, w_);
  take_velocity();
  const double residual = natural_residual();
  const double most = std::min(kMostLoss * std::max(best_residual_, limits.tolerance), limits.accepted);
  if (!(residual <= std::max(best_residual_, most))) return;
  best_residual_ = residual;
  best_x_ = x_;
}

}  // namespace lcpbench
