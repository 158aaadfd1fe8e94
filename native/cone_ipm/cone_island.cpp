#include "native/cone_ipm/cone_island.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/timed_solve.h"
#include "native/contacts/contact_impulses.h"

namespace lcpbench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kBoundaryFraction = 0.99;
constexpr double kShortestStep = 1e-8;
constexpr double kLongestStep = 1 / kBoundaryFraction;  // what is longer is cut to 1
/// Steps in which the residual does not fall to a half before the iteration ends as stalled: fewer near a solution,
/// where finish() takes over.
constexpr int kMostIdleSteps = 25;
constexpr int kMostIdleStepsNear = 6;
constexpr int kMostIdleStepsAccepted = 1;
constexpr double kNear = 1e-6;
/// The method of multipliers is tried before the interior point and on its way: its first weight, and from which
/// residual on. Near a solution without strict complementarity the interior point takes many steps, and a large weight
/// few.
constexpr double kFirstWeight = 30;
struct Try {
  double residual;
  double weight;
};
constexpr std::array<Try, 2> kTries{{{1e-3, kFirstWeight}, {1e-5, 1e4}}};
constexpr int kMostIdleRounds = 20;
constexpr double kProgress = 0.5;

/// x_0^2 - |x_t|^2.
double determinant(const Vector3d& x) {
  const double length = x.tail<2>().norm();
  return (x(0) - length) * (x(0) + length);
}

Vector3d reflect(const Vector3d& x) { return {x(0), -x(1), -x(2)}; }

/// The product of the cone's algebra.
Vector3d product(const Vector3d& a, const Vector3d& b) {
  Vector3d result;
  result(0) = a.dot(b);
  result.tail<2>() = a(0) * b.tail<2>() + b(0) * a.tail<2>();
  return result;
}

/// z with product(a, z) = b.
Vector3d divide(const Vector3d& b, const Vector3d& a) {
  Vector3d result;
  const double across = a.tail<2>().dot(b.tail<2>());
  result(0) = (a(0) * b(0) - across) / determinant(a);
  result.tail<2>() = (b.tail<2>() - result(0) * a.tail<2>()) / a(0);
  return result;
}

/// The symmetric matrix of a scaling point of determinant 1, times x.
Vector3d transform(const Vector3d& point, const Vector3d& x) {
  const double across = point.tail<2>().dot(x.tail<2>());
  Vector3d result;
  result(0) = point(0) * x(0) + across;
  result.tail<2>() = x.tail<2>() + (x(0) + across / (1 + point(0))) * point.tail<2>();
  return result;
}

/// The nearest point of the cone |x_t| <= x_0.
Vector3d nearest_in_cone(const Vector3d& x) {
  const double length = x.tail<2>().norm();
  if (length <= x(0)) return x;
  if (length <= -x(0)) return Vector3d::Zero();
  const double height = (x(0) + length) / 2;
  return {height, height * x(1) / length, height * x(2) / length};
}

/// Down to the largest length for which x + length d stays in the cone, if that is less.
void shorten(const Vector3d& x, const Vector3d& d, double& length) {
  const double a = determinant(d);
  const double b = x(0) * d(0) - x.tail<2>().dot(d.tail<2>());
  const double c = std::max(determinant(x), 0.0);
  if (d(0) < 0) length = std::min(length, -x(0) / d(0));
  // a t^2 + 2 b t + c is not negative in between: at its ends, and at its least value where that is there.
  const bool falls_within = b < 0 && -b < a * length;
  if ((a * length + 2 * b) * length + c >= 0 && !(falls_within && b * b > a * c)) return;
  const double discriminant = b * b - a * c;
  if (!(discriminant >= 0)) return;
  const double root = std::sqrt(discriminant);
  // Of a t^2 + 2 b t + c = 0, without cancellation.
  const double sum = b >= 0 ? -(b + root) : -(b - root);
  for (const double t : {sum != 0 ? c / sum : length, a != 0 ? sum / a : length}) {
    if (t > 0 && t < length) length = t;
  }
}

}  // namespace

void ConeIsland::project(const Vector& w, Vector& rows) const {
  const double* entries = entries_.data();
  for (const Contact& contact : contacts_) {
    const Index* columns = columns_.data() + contact.first;
    double* to = rows.data() + contact.row;
    double sum[3] = {};
    if (contact.rows == 1) {
      for (Index k = 0; k < contact.columns; ++k) sum[0] += entries[k] * w(columns[k]);
      to[0] = sum[0];
      entries += contact.columns;
      continue;
    }
    for (Index k = 0; k < contact.columns; ++k, entries += 3) {
      const double value = w(columns[k]);
      for (int r = 0; r < 3; ++r) sum[r] += entries[r] * value;
    }
    std::copy(sum, sum + 3, to);
  }
}

void ConeIsland::combine(const Vector& rows, Vector& w) const {
  w.setZero();
  const double* entries = entries_.data();
  for (const Contact& contact : contacts_) {
    const Index* columns = columns_.data() + contact.first;
    const double* from = rows.data() + contact.row;
    if (contact.rows == 1) {
      for (Index k = 0; k < contact.columns; ++k) w(columns[k]) += entries[k] * from[0];
      entries += contact.columns;
      continue;
    }
    for (Index k = 0; k < contact.columns; ++k, entries += 3) {
      w(columns[k]) += entries[0] * from[0] + entries[1] * from[1] + entries[2] * from[2];
    }
  }
}

void ConeIsland::take_rigid_velocity() {
  project(w_, u_);
  u_ += q_;
}

void ConeIsland::take_velocity() {
  take_rigid_velocity();
  if (!is_soft_) return;
  for (const Contact& contact : contacts_) {
    for (Index k = 0; k < contact.rows; ++k) u_(contact.row + k) += contact.compliance(k) * x_(contact.row + k);
  }
}

void ConeIsland::set_start() {
  x_.setZero();
  y_.setZero();
  for (const Contact& contact : contacts_) {
    const double diagonal = contact.diagonal();
    y_(contact.row) = std::max(1.0, 1 / contact.scale()) * q_max_;
    x_(contact.row) = diagonal > 0 ? y_(contact.row) / diagonal : 1.0;
  }
  combine(x_, w_);
}

/// The largest of |min(u_N, M_nn f_N)| and of the distances between M_tt f_t and the point nearest to M_tt f_t - u_t in
/// the disc of radius M_tt mu f_N, over the scale. NaN in u_ gives infinity. @pre u_ = A w_ + R x_ + q_ at w_ = A'x_
double ConeIsland::natural_residual() const {
  double worst = 0;
  const auto take = [&](double value) { worst = max_or_infinity(worst, value); };
  for (const Contact& contact : contacts_) {
    const double impulse = x_(contact.row) / contact.scale();
    // The velocity goes first: std::min returns its first argument where that is NaN.
    take(std::abs(std::min(u_(contact.row) * contact.scale(), contact.diagonal_normal * impulse)));
    if (contact.rows == 1) continue;
    const Eigen::Vector2d f = contact.diagonal_tangent * x_.segment<2>(contact.row + 1);
    const Eigen::Vector2d aim = f - u_.segment<2>(contact.row + 1);
    const double radius = contact.diagonal_tangent * x_(contact.row);
    const double length = aim.norm();
    take((f - (length > radius ? radius / length : 1.0) * aim).norm());
  }
  return worst / scale_;
}

/// Of the convex problem with the slip held [m/s, in the units of u_]: x less the nearest point of the cone to x - y,
/// times the diagonal.
double ConeIsland::convex_residual(const Vector& y) const {
  double worst = 0;
  for (const Contact& contact : contacts_) {
    const double diagonal = contact.diagonal();
    if (contact.rows == 1) {
      worst = max_or_infinity(worst, std::abs(std::min(diagonal * x_(contact.row), y(contact.row))));
      continue;
    }
    const Vector3d x = diagonal * x_.segment<3>(contact.row);
    worst = max_or_infinity(worst, (x - nearest_in_cone(x - y.segment<3>(contact.row))).norm());
  }
  return worst;
}

double ConeIsland::keep_best() {
  const double residual = is_relaxed_ ? convex_residual(u_) / scale_ : natural_residual();
  if (residual < best_residual_) {
    best_residual_ = residual;
    best_x_ = x_;
  }
  return residual;
}

bool ConeIsland::scale(std::size_t index, Slip slip) {
  const Contact& contact = contacts_[index];
  Scaling& scaling = scalings_[index];
  if (contact.rows == 1) {
    const double x = x_(contact.row);
    const double y = y_(contact.row);
    scaling.size = std::sqrt(y / x);
    scaling.lambda(0) = std::sqrt(x * y);
    scaling.weight(0, 0) = x / y;
    if (is_soft_) {
      scaling.soft(0, 0) = 1 / (1 + contact.compliance(0) * x / y);
      scaling.weight(0, 0) *= scaling.soft(0, 0);
    }
    return std::isfinite(scaling.size) && scaling.size > 0;
  }
  const Vector3d x = x_.segment<3>(contact.row);
  const Vector3d y = y_.segment<3>(contact.row);
  const double root_x = std::sqrt(determinant(x));
  const double root_y = std::sqrt(determinant(y));
  if (!(root_x > 0) || !(root_y > 0)) return false;
  const Vector3d unit_x = x / root_x;
  const Vector3d unit_y = y / root_y;
  const double gamma = std::sqrt((1 + unit_x.dot(unit_y)) / 2);
  scaling.point = (unit_y + reflect(unit_x)) / (2 * gamma);
  scaling.size = std::sqrt(root_y / root_x);
  scaling.lambda = scaling.size * transform(scaling.point, x);
  const Vector3d reflected = reflect(scaling.point);
  scaling.weight = 2 * reflected * reflected.transpose();
  scaling.weight(0, 0) -= 1;
  scaling.weight(1, 1) += 1;
  scaling.weight(2, 2) += 1;
  scaling.weight /= scaling.size * scaling.size;
  const double length = y.tail<2>().norm();
  if (slip == Slip::kNewton && length > 0) {
    const Eigen::Vector2d direction = y.tail<2>() / length;
    scaling.weight.rightCols<2>() += scaling.weight.col(0).eval() * direction.transpose();
  }
  if (is_soft_) {
    scaling.soft = (Matrix3d::Identity() + scaling.weight * contact.compliance.asDiagonal()).inverse();
    scaling.weight = (scaling.soft * scaling.weight).eval();
  }
  return scaling.weight.allFinite();
}

/// I + A'PA with the weights P of the contacts.
bool ConeIsland::factor() {
  Matrix& K = lu_.matrix();
  K.setIdentity();
  const double* entries = entries_.data();
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Contact& contact = contacts_[c];
    const Matrix3d& weight = scalings_[c].weight;
    const Index* columns = columns_.data() + contact.first;
    for (Index j = 0; j < contact.columns; ++j) {
      double* to = K.col(columns[j]).data();
      if (contact.rows == 1) {
        const double value = weight(0, 0) * entries[j];
        for (Index i = 0; i < contact.columns; ++i) to[columns[i]] += entries[i] * value;
        continue;
      }
      const double* e = entries + 3 * j;
      const double a = weight(0, 0) * e[0] + weight(0, 1) * e[1] + weight(0, 2) * e[2];
      const double b = weight(1, 0) * e[0] + weight(1, 1) * e[1] + weight(1, 2) * e[2];
      const double d = weight(2, 0) * e[0] + weight(2, 1) * e[1] + weight(2, 2) * e[2];
      for (Index i = 0; i < contact.columns; ++i) {
        to[columns[i]] += entries[3 * i] * a + entries[3 * i + 1] * b + entries[3 * i + 2] * d;
      }
    }
    entries += contact.rows * contact.columns;
  }
  return lu_.factor();
}

/// T^-1 (lambda \ (centre e - lambda o lambda - (T dx) o (T^-1 dy))), of which the part of lambda o lambda is -x.
void ConeIsland::set_target(std::size_t index, double centre) {
  const Contact& contact = contacts_[index];
  const Scaling& scaling = scalings_[index];
  if (contact.rows == 1) {
    const double second = dx_(contact.row) * dy_(contact.row);
    target_(contact.row) = (centre - second) / scaling.lambda(0) / scaling.size - x_(contact.row);
    return;
  }
  const Vector3d reflected = reflect(scaling.point);
  Vector3d right = -product(transform(scaling.point, dx_.segment<3>(contact.row)),
                            transform(reflected, dy_.segment<3>(contact.row)));
  right(0) += centre;
  target_.segment<3>(contact.row) =
      transform(reflected, divide(right, scaling.lambda)) / scaling.size - x_.segment<3>(contact.row);
}

/// With P = S T^-2 B^-1: (I + A'PA) dw = A'(S target + P r), dx = S target - P (A dw - r),
/// dy = B^-1 (A dw + R dx - r), r being residual_. S target takes the place of target_.
/// @pre factor_scaled() and find_residual() with this slip; target_ is new
void ConeIsland::find_direction(Slip slip) {
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Contact& contact = contacts_[c];
    if (is_soft_ && contact.rows == 1) target_(contact.row) *= scalings_[c].soft(0, 0);
    if (is_soft_ && contact.rows == 3) {
      target_.segment<3>(contact.row) = (scalings_[c].soft * target_.segment<3>(contact.row)).eval();
    }
    if (contact.rows == 1) {
      rows_(contact.row) = target_(contact.row) + scalings_[c].weight(0, 0) * residual_(contact.row);
    } else {
      rows_.segment<3>(contact.row) =
          target_.segment<3>(contact.row) + scalings_[c].weight * residual_.segment<3>(contact.row);
    }
  }
  combine(rows_, dw_);
  lu_.solve(dw_);
  project(dw_, rows_);
  rows_ -= residual_;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Contact& contact = contacts_[c];
    const Index row = contact.row;
    if (contact.rows == 1) {
      dx_(row) = target_(row) - scalings_[c].weight(0, 0) * rows_(row);
      dy_(row) = rows_(row) + contact.compliance(0) * dx_(row);
      continue;
    }
    dx_.segment<3>(row) = target_.segment<3>(row) - scalings_[c].weight * rows_.segment<3>(row);
    if (is_soft_) rows_.segment<3>(row) += contact.compliance.cwiseProduct(dx_.segment<3>(row));
    dy_.segment<3>(row) = rows_.segment<3>(row);
    const double length = y_.segment<2>(row + 1).norm();
    if (slip == Slip::kNewton && length > 0) {
      dy_(row) += y_.segment<2>(row + 1).dot(rows_.segment<2>(row + 1)) / length;
    }
  }
}

double ConeIsland::longest_step() const {
  double length = kLongestStep;
  for (const Contact& contact : contacts_) {
    for (const auto& [at, step] : {std::pair<const Vector&, const Vector&>(x_, dx_), {y_, dy_}}) {
      if (contact.rows == 3) {
        shorten(at.segment<3>(contact.row), step.segment<3>(contact.row), length);
      } else if (step(contact.row) < 0) {
        length = std::min(length, -at(contact.row) / step(contact.row));
      }
    }
  }
  return length;
}

double ConeIsland::gap_after(double length) const { return (x_ + length * dx_).dot(y_ + length * dy_); }

void ConeIsland::find_residual(Slip slip) {
  residual_ = y_ - u_ - slip_;
  if (slip != Slip::kNewton) return;
  for (const Contact& contact : contacts_) {
    if (contact.rows == 3) residual_(contact.row) -= y_.segment<2>(contact.row + 1).norm();
  }
}

/// The weights, and the factors of the Newton matrix.
bool ConeIsland::factor_scaled(Slip slip) {
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    if (!scale(c, slip)) return false;
  }
  return factor();
}

/// Mehrotra's predictor, and then the step that it corrects.
void ConeIsland::find_step(Slip slip) {
  target_ = -x_;
  find_direction(slip);
  const double gap = x_.dot(y_);
  const double predicted = std::max(gap_after(std::min(1.0, longest_step())) / gap, 0.0);
  const double centering = std::min(predicted * predicted * predicted, 1.0);
  const double centre = centering * gap / static_cast<double>(contacts_.size());
  for (std::size_t c = 0; c < contacts_.size(); ++c) set_target(c, centre);
  find_direction(slip);
}

ConeIsland::Stop ConeIsland::iterate(Slip slip, const ConeLimits& limits, Counters& counters) {
  double best = kInfinity;
  int idle_steps = 0;
  std::size_t tries = 0;
  for (;; ++counters.iterations) {
    combine(x_, w_);
    take_velocity();
    const double residual = keep_best();
    if (slip != Slip::kNone && best_residual_ <= limits.tolerance) return Stop::kConverged;
    if (slip == Slip::kNewton && tries < kTries.size() && best_residual_ <= kTries[tries].residual) {
      while (tries < kTries.size() && best_residual_ <= kTries[tries].residual) ++tries;
      dx_ = x_;
      dy_ = best_x_;
      const double before = best_residual_;
      if (try_multipliers(kTries[tries - 1].weight, limits, counters)) return Stop::kConverged;
      x_ = dx_;
      if (!(best_residual_ <= limits.accepted)) {
        best_x_ = dy_;  // an interior point is the better start for finish()
        best_residual_ = before;
      }
      combine(x_, w_);
      take_velocity();
    }
    find_residual(slip);
    const double off = std::max(residual_.lpNorm<Eigen::Infinity>() / scale_, residual);
    const double enough = std::max(limits.tolerance * scale_, 1e-13 * q_max_);
    if (slip != Slip::kNewton && residual_.lpNorm<Eigen::Infinity>() <= enough && convex_residual(y_) <= enough) {
      return Stop::kConverged;
    }
    idle_steps = off < kProgress * best ? 0 : idle_steps + 1;
    best = std::min(best, off);
    const int most_idle = best_residual_ <= limits.accepted ? kMostIdleStepsAccepted
                          : best_residual_ <= kNear         ? kMostIdleStepsNear
                                                            : kMostIdleSteps;
    if (idle_steps > most_idle) return Stop::kStalled;
    if (counters.iterations >= limits.max_iterations) return Stop::kIterationLimit;
    if (!(wall_clock_s() < limits.deadline_s)) return Stop::kTimeLimit;
    if (!factor_scaled(slip)) return Stop::kBreakdown;
    ++counters.factorizations;
    find_step(slip);
    if (!dx_.allFinite() || !dy_.allFinite()) return Stop::kBreakdown;
    const double length = std::min(1.0, kBoundaryFraction * longest_step());
    if (!(length >= kShortestStep)) return Stop::kStalled;
    x_ += length * dx_;
    y_ += length * dy_;
  }
}

void ConeIsland::start() {
  x_.setZero();
  best_x_.setZero();
  u_ = q_;
  scale_ = std::max(approach_, floor_);
  best_residual_ = natural_residual();
}

ConeIsland::Stop ConeIsland::solve(Slip slip, const ConeLimits& limits, Counters& counters) {
  is_relaxed_ = slip == Slip::kNone;
  if (is_relaxed_) {
    const double without = convex_residual(u_);  // of no impulse
    scale_ = std::max(without, floor_);
    best_residual_ = without / scale_;
  }
  if (best_residual_ <= limits.tolerance) return Stop::kConverged;
  slip_.setZero();
  if (slip != Slip::kRounds && try_multipliers(kFirstWeight, limits, counters)) {
    if (is_relaxed_) {
      finish(limits, counters);
    } else {
      drop_separating(limits);
    }
    return Stop::kConverged;
  }
  if (slip != Slip::kRounds) {
    set_start();
    const Stop stop = iterate(slip, limits, counters);
    if (!is_limit(stop)) finish(limits, counters);
    if (!is_relaxed_) drop_separating(limits);
    return stop;
  }
  double best = kInfinity;
  Stop stop = Stop::kStalled;
  for (int idle_rounds = 0; idle_rounds <= kMostIdleRounds;) {
    set_start();
    stop = iterate(slip, limits, counters);
    if (best_residual_ <= limits.tolerance) break;
    if (is_limit(stop)) return stop;
    idle_rounds = best_residual_ < kProgress * best ? 0 : idle_rounds + 1;
    if (idle_rounds == 0) best = best_residual_;
    for (const Contact& contact : contacts_) {
      if (contact.rows == 3) slip_(contact.row) = u_.segment<2>(contact.row + 1).norm();
    }
  }
  finish(limits, counters);
  drop_separating(limits);
  return stop;
}

/// From the contacts as given: A may be in other coordinates, of which all move by rounding what one of them moves.
void ConeIsland::add_velocity_change(const ContactProblem& island, Vector& u) {
  momentum_.setZero(u.size());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const auto add = [&](const Jacobian& J, Index j, double f) {
      std::visit([&](const auto& matrix) { momentum_ += f * matrix.col(j); }, J);
    };
    const Vector3d f = impulse(static_cast<Index>(c));
    add(island.N, static_cast<Index>(c), f(0));
    if (contacts_[c].rows == 1) continue;
    add(island.D, contacts_[c].tangents[0], f(1));
    add(island.D, contacts_[c].tangents[1], f(2));
  }
  whitened_.noalias() = root_.transpose() * momentum_;
  u.noalias() += root_ * whitened_;
}

Vector3d ConeIsland::impulse(Index contact) const {
  const Contact& from = contacts_[static_cast<std::size_t>(contact)];
  if (from.rows == 1) return {unit_ * best_x_(from.row), 0, 0};
  return unit_ * Vector3d(best_x_(from.row) / from.mu, best_x_(from.row + 1), best_x_(from.row + 2));
}

}  // namespace lcpbench
