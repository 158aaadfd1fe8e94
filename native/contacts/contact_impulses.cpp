#include "native/contacts/contact_impulses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <variant>

#include "core/compliance.h"
#include "core/solver.h"

namespace lcpbench {

void ContactImpulses::load(const Problem& problem) {
  b_.resize(0);
  for (Vector* soft : {&given_offset_t_, &compliance, &compliance_t}) soft->resize(0);
  tangents.resize(2, 0);
  idle_.clear();
  frictions.clear();
  if (problem.contact() != nullptr) {
    load_contacts(*problem.contact());
  } else {
    load_lcp(make_lcp(problem));
  }
  u.resize(u0.size());
  impulse.resize(columns.diagonal.size());
}

void ContactImpulses::load_lcp(const Lcp& lcp) {
  contacts = lcp.size();
  is_bare_ = true;
  columns.J.clear();
  columns.response.clear();
  momentum_.resize(0);
  for (Index i = 0; i < contacts; ++i) {
    columns.J.add_column();
    columns.J.add_run(i, Vector::Ones(1));
    columns.response.add_column();
    columns.response.add_run(0, lcp.M.col(i));
  }
  columns.diagonal = lcp.M.diagonal();
  units.load(lcp.M);
  mu.setZero(contacts);
  friction_of.assign(static_cast<std::size_t>(contacts), -1);
  set_velocity(lcp.q);
}

void ContactImpulses::load_contacts(const ContactProblem& problem) {
  const ContactLayout layout = contact_layout(problem);
  contacts = layout.nc;
  is_bare_ = false;
  const bool by_blocks = std::holds_alternative<BlockInertia>(problem.inertia);
  inverse_ = BlockInverse(problem.inertia);
  find_contact_columns(problem, inverse_, Opposites::kEmpty, !by_blocks, columns);
  momentum_.resize(by_blocks ? problem.ngc() : 0);
  units.load(problem);
  mu = problem.mu;
  b_ = problem.b;
  compliance = problem.compliance_n;
  columns.diagonal.head(compliance.size()) += compliance;
  const Vector ones = Vector::Ones(problem.ngc());
  for (Index i = 0; i < b_.size(); ++i) {
    if (columns.J.dot_magnitudes(i, ones) == 0 && !(problem.normal_compliance(i) > 0)) idle_.push_back(i);
  }
  friction_of.assign(static_cast<std::size_t>(contacts), -1);
  for (Index contact = 0; contact < contacts; ++contact) {
    const auto c = static_cast<std::size_t>(contact);
    if (layout.lambda[c] < 0) continue;
    friction_of[c] = static_cast<Index>(frictions.size());
    frictions.push_back({.contact = contact,
                         .first_column = layout.friction_offset() + layout.friction_begin[c],
                         .directions = problem.edges[c] / 2,
                         .lambda = layout.lambda_offset() + layout.lambda[c]});
  }
  if (problem.compliance_t.size() > 0 || problem.offset_t.size() > 0) load_tangents(problem);
  set_velocity(problem.v);
}

void ContactImpulses::load_tangents(const ContactProblem& problem) {
  compliance_t = problem.compliance_t;
  given_offset_t_ = problem.offset_t;
  tangents.setZero(2, columns.diagonal.size());
  for (const SignedFriction& friction : frictions) {
    for (Index t = 0; t < friction.directions; ++t) {
      const std::array<double, 2> direction = edge_direction(t, 2 * friction.directions);
      const Index column = friction.first_column + t;
      tangents.col(column) << direction[0], direction[1];
      columns.diagonal(column) += problem.tangential_compliance(friction.contact) * tangents.col(column).squaredNorm();
    }
  }
}

/// Raises `speed`.
IslandUnits::Row ContactImpulses::measure_row(Index column, Index contact) {
  const bool is_normal = column < contacts;
  const double velocity = columns.J.dot(column, u0);
  double of_offset = offset.size() > 0 && is_normal ? offset(column) : 0, magnitude = std::abs(of_offset);
  if (offset_t.size() > 0) {
    const auto along = tangents.col(column).cwiseProduct(offset_t.segment<2>(2 * contact));
    of_offset += along.sum();
    magnitude += along.cwiseAbs().sum();
  }
  if (is_bare_) {
    const double size = std::abs(velocity);
    speed = max_or_infinity(speed, size);
    return {.approach = size, .magnitudes = size};
  }
  const double q = velocity + of_offset;
  speed = max_or_infinity(speed, is_normal ? -q : std::abs(q));
  return row_of_units(is_normal, velocity, columns.J.dot_magnitudes(column, u0),
                      static_cast<double>(columns.J.entries(column)), of_offset, magnitude);
}

void ContactImpulses::set_velocity(const Vector& v) {
  u0 = v;
  offset = b_;
  for (const Index i : idle_) offset(i) = std::min(b_(i), 0.0);
  offset_t = given_offset_t_;
  speed = 0;
  units.clear();
  IslandUnits::Row largest;
  for_each_impulse([&](Index column, Index contact) {
    const IslandUnits::Row row = measure_row(column, contact);
    largest.approach = max_or_infinity(largest.approach, row.approach);
    largest.floor = max_or_infinity(largest.floor, row.floor);
    units.add_row(contact, row);
  });
  scale = largest.approach > 0 ? std::max(largest.approach, largest.floor) : 0;
  for (const Index i : idle_) offset(i) = std::min(b_(i), speed);
  if (units.several()) scale_islands();
}

void ContactImpulses::scale_islands() {
  units.choose(u0);
  if (units.largest_scale() > 0) scale = units.largest_scale();
  units.scale(u0);
  for (Index i = 0; i < offset.size(); ++i) offset(i) *= units.of_contact(i);
  for (Index i = 0; i < offset_t.size(); ++i) offset_t(i) *= units.of_contact(i / 2);
  speed = 0;
  for_each_impulse([this](Index column, Index contact) { measure_row(column, contact); });
}

void ContactImpulses::set_impulses(const Vector& z) {
  impulse.setZero();
  impulse.head(contacts) = z.head(contacts);
  for (const SignedFriction& friction : frictions) {
    const Index first = friction.first_column;
    impulse.segment(first, friction.directions) =
        z.segment(first, friction.directions) - z.segment(first + friction.directions, friction.directions);
  }
  scale_impulses();
  recompute_velocity();
}

void ContactImpulses::scale_impulses() {
  for_each_impulse([&](Index column, Index contact) { impulse(column) *= units.of_contact(contact); });
}

/// to += the columns times the impulses.
void ContactImpulses::add_impulses(const PackedColumns& of, Vector& to) const {
  for_each_impulse([&](Index column, Index) {
    if (impulse(column) != 0) of.add_to(to, column, impulse(column));
  });
}

void ContactImpulses::recompute_velocity() {
  u = u0;
  if (u.size() == 0) return;  // without coordinates neither the columns nor their responses have entries
  if (momentum_.size() == 0) return add_impulses(columns.response, u);
  momentum_.setZero();
  add_impulses(columns.J, momentum_);
  inverse_.add_product(momentum_, u);
}

ContactImpulses::Tangential ContactImpulses::tangential_offset(const SignedFriction& friction) const {
  Tangential beside = Tangential::Zero();
  if (offset_t.size() > 0) beside = offset_t.segment<2>(2 * friction.contact);
  if (compliance_t.size() == 0) return beside;
  for (Index t = friction.first_column; t < friction.first_column + friction.directions; ++t) {
    beside += compliance_t(friction.contact) * impulse(t) * tangents.col(t);
  }
  return beside;
}

double ContactImpulses::slip_bound(const SignedFriction& friction) const {
  const Tangential beside = tangential_offset(friction);
  double bound = 0;
  for (Index t = 0; t < friction.directions; ++t) {
    bound = max_or_infinity(bound, std::abs(slip(friction.first_column + t, beside)));
  }
  return bound;
}

/// Of the contact's friction rows and its cone row, at lambda = max |d_t'u|.
double ContactImpulses::friction_residual(const SignedFriction& friction) const {
  const double lambda = slip_bound(friction);
  const double used = impulse.segment(friction.first_column, friction.directions).lpNorm<1>();
  const double slack = mu(friction.contact) * impulse(friction.contact) - used;
  const Tangential beside = tangential_offset(friction);
  double worst = std::abs(std::min(lambda, columns.diagonal(friction.contact) * slack));
  for (Index t = friction.first_column; t < friction.first_column + friction.directions; ++t) {
    const double own = slip(t, beside);
    const double moved = columns.diagonal(t) * impulse(t);
    worst = max_or_infinity(worst, std::abs(std::min(lambda + own, std::max(moved, 0.0))));
    worst = max_or_infinity(worst, std::abs(std::min(lambda - own, std::max(-moved, 0.0))));
  }
  return worst;
}

/// std::min and std::max give their first argument where one is NaN: the velocity stands there.
double ContactImpulses::residual() const {
  double worst = 0;
  for (Index i = 0; i < contacts; ++i) {
    const double w = normal_velocity(i);
    worst = max_or_infinity(worst, std::abs(std::min(w, std::max(columns.diagonal(i), 0.0) * impulse(i))));
  }
  for (const SignedFriction& friction : frictions) worst = max_or_infinity(worst, friction_residual(friction));
  return worst;
}

void ContactImpulses::drop_what_counts_as_zero() {
  for (Index i = 0; i < contacts; ++i) {
    if (columns.diagonal(i) * impulse(i) < normal_velocity(i)) impulse(i) = 0;
  }
  for (const SignedFriction& friction : frictions) {
    const double lambda = slip_bound(friction);
    const Tangential beside = tangential_offset(friction);
    for (Index t = friction.first_column; t < friction.first_column + friction.directions; ++t) {
      const double own = slip(t, beside);
      const double w = impulse(t) > 0 ? lambda + own : lambda - own;
      if (!(impulse(friction.contact) > 0) || columns.diagonal(t) * std::abs(impulse(t)) < w) impulse(t) = 0;
    }
  }
  recompute_velocity();
}

void ContactImpulses::write_answer(Vector& z) const {
  z.head(contacts) = impulse.head(contacts);
  for (const SignedFriction& friction : frictions) {
    const auto g = impulse.segment(friction.first_column, friction.directions);
    z.segment(friction.first_column, friction.directions) = g.cwiseMax(0.0);
    z.segment(friction.first_column + friction.directions, friction.directions) =
        (0.0 - g.array()).max(0.0);  // not -g: no negative zeros
    z(friction.lambda) = slip_bound(friction);
  }
  if (!units.several()) return;
  for (Index i = 0; i < contacts; ++i) z(i) /= units.of_contact(i);
  for (const SignedFriction& friction : frictions) {
    const double unit = units.of_contact(friction.contact);
    z.segment(friction.first_column, 2 * friction.directions) /= unit;
    z(friction.lambda) /= unit;
  }
}

}  // namespace lcpbench
