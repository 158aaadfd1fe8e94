#include "native/cone_ipm/cone_test.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/entries.h"
#include "native/contacts/contact_impulses.h"

namespace lcpbench {
namespace {

std::size_t place(Index i) { return static_cast<std::size_t>(i); }

/// Calls f(row, entry) for each entry of a column of [N D].
template <class F>
void for_each_row(const ContactProblem& problem, Index column, F&& f) {
  const auto visit = [&](Index row, double entry) { f(place(row), entry); };
  if (column < problem.nc()) return for_each_entry(problem.N, column, visit);
  for_each_entry(problem.D, column - problem.nc(), visit);
}

Quad length(Quad a, Quad b) { return sqrt(a * a + b * b); }

}  // namespace

void ConeTest::load(const ContactProblem& problem, bool convex) {
  problem_ = &problem;
  convex_ = convex;
  layout_ = contact_layout(problem);
  islands_ = row_islands(problem);
  u_.assign(place(problem.ngc()), 0);
  residuals_.resize(place(islands_.count));
  scales_.resize(place(islands_.count));
  none_.setZero(layout_.size());
  normal_.assign(place(layout_.nc), 0);
  tangent_.assign(place(layout_.nc), 0);
  inertia_.emplace(problem.inertia);
  for (Index contact = 0; contact < layout_.nc && inertia_->well_defined(); ++contact) {
    normal_[place(contact)] = diagonal(contact) + problem.normal_compliance(contact);
    if (layout_.lambda[place(contact)] < 0) continue;
    const Index first = layout_.friction_offset() + layout_.friction_begin[place(contact)];
    tangent_[place(contact)] =
        std::max(diagonal(first), diagonal(first + problem.edges[place(contact)] / 4)) +
        problem.tangential_compliance(contact);
  }
}

Quad ConeTest::project(Index column, const QuadVector& x) const {
  Quad sum = 0;
  for_each_row(*problem_, column, [&](std::size_t row, double entry) { sum += entry * x[row]; });
  return sum;
}

Quad ConeTest::diagonal(Index column) {
  std::vector<std::size_t> pattern;
  for_each_row(*problem_, column, [&](std::size_t row, double entry) {
    u_[row] = entry;
    pattern.push_back(row);
  });
  inertia_->solve(u_, pattern);
  const Quad sum = project(column, u_);
  for (const std::size_t row : pattern) u_[row] = 0;
  return sum;
}

/// f_t and w_t = J_t'u + offset + compliance f_t along the two tangents.
ConeTest::Tangential ConeTest::tangential(Index contact, const Vector& z) const {
  const Index first = layout_.friction_offset() + layout_.friction_begin[place(contact)];
  const Index edges = problem_->edges[place(contact)];
  Tangential t;
  for (Index k = 0; k < edges; ++k) {
    const double f = z(first + k);
    // Not rounded to 2^-40 as edge_direction(): the evaluation does not round them either.
    const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(edges);
    t.f1 += f * (4 * k % edges == 0 ? std::round(std::cos(angle)) : std::cos(angle));
    t.f2 += f * (4 * k % edges == 0 ? std::round(std::sin(angle)) : std::sin(angle));
  }
  const double compliance = problem_->tangential_compliance(contact);
  t.w1 = project(first, u_) + problem_->tangential_offset(contact, 0) + compliance * t.f1;
  t.w2 = project(first + edges / 4, u_) + problem_->tangential_offset(contact, 1) + compliance * t.f2;
  return t;
}

/// w_N = N'v+ + b + r_n f_N [m/s]. @pre u_ is the velocity v+ under the impulses of z
Quad ConeTest::normal_velocity(Index contact, const Vector& z) const {
  return project(contact, u_) + problem_->offset(contact) + Quad{problem_->normal_compliance(contact)} * z(contact);
}

/// m |f - P(f - w / m)|, P onto the cone |f_t| <= mu f_N, m the larger of M_nn and M_tt.
Quad ConeTest::convex_residual(Index contact, const Vector& z) const {
  const Tangential t = tangential(contact, z);
  const Quad m = std::max(normal_[place(contact)], tangent_[place(contact)]);
  const Quad scaled = m * z(contact), w = normal_velocity(contact, z);
  const Quad mu = problem_->mu(contact);
  // These two cases need no projection: scaled - height would cancel, and lose w where m is huge.
  if (mu == 0) return length(std::min(scaled, w), length(m * t.f1, m * t.f2));
  const Quad trial = scaled - w, trial1 = m * t.f1 - t.w1, trial2 = m * t.f2 - t.w2;
  const Quad size = length(trial1, trial2);
  if (trial >= 0 && size <= mu * trial) return length(length(w, t.w1), t.w2);
  const Quad height = std::max((trial + mu * size) / (1 + mu * mu), Quad{0});
  const Quad share = size == 0 ? 0 : mu * height / size;
  return length(scaled - height, length(m * t.f1 - share * trial1, m * t.f2 - share * trial2));
}

/// |M_tt f_t - P(M_tt f_t - w_t)|, P onto the disc of radius mu M_tt max(f_N, 0).
Quad ConeTest::friction_residual(Index contact, const Vector& z) const {
  const auto [f1, f2, w1, w2] = tangential(contact, z);
  if (f1 == 0 && f2 == 0 && !(z(contact) > 0)) return 0;
  const Quad weight = tangent_[place(contact)];
  const Quad trial1 = weight * f1 - w1, trial2 = weight * f2 - w2;
  const Quad radius = problem_->mu(contact) * weight * std::max(z(contact), 0.0);
  const Quad size = length(trial1, trial2);
  const Quad share = size > radius ? radius / size : 1;
  return length(weight * f1 - share * trial1, weight * f2 - share * trial2);
}

/// Of each island, from v alone. Leaves v in u_.
void ConeTest::measure_scales(const Vector& v) {
  for (Index i = 0; i < v.size(); ++i) u_[place(i)] = v(i);
  std::fill(scales_.begin(), scales_.end(), ContactScale<Quad>{});
  for (Index row = 0; row < layout_.lambda_offset(); ++row) {
    Quad velocity = 0, terms = 0;
    double entries = 0;
    for_each_row(*problem_, row, [&](std::size_t i, double entry) {
      const Quad term = Quad{entry} * v(static_cast<Index>(i));
      velocity += term;
      terms += abs(term);
      ++entries;
    });
    ContactScale<Quad>& scale = scales_[place(islands_.of_row[place(row)])];
    scale.add_row(velocity, terms, entries);
    if (row >= layout_.nc) continue;
    if (convex_ && layout_.lambda[place(row)] >= 0) {
      scale.without = std::max(scale.without, convex_residual(row, none_));
    } else {
      scale.add_approach(velocity + problem_->offset(row));
    }
  }
}

double ConeTest::residual(const Vector& v, const Vector& z, double error) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (!inertia_->well_defined()) return kInfinity;
  measure_scales(v);
  std::fill(u_.begin(), u_.end(), 0);
  for (Index j = 0; j < layout_.lambda_offset(); ++j) {
    if (z(j) == 0) continue;
    for_each_row(*problem_, j, [&](std::size_t row, double entry) { u_[row] += Quad{entry} * z(j); });
  }
  inertia_->solve(u_);
  for (Index i = 0; i < v.size(); ++i) u_[place(i)] += v(i);
  std::fill(residuals_.begin(), residuals_.end(), 0);
  for (Index row = 0; row < layout_.nc; ++row) {
    Quad& residual = residuals_[place(islands_.of_row[place(row)])];
    if (convex_ && layout_.lambda[place(row)] >= 0) {
      residual = max_or_infinity(residual, convex_residual(row, z));
      continue;
    }
    const Quad w = normal_velocity(row, z);
    const Quad normal = z(row) == 0 ? std::min(w, Quad{0}) : std::min(w, normal_[place(row)] * z(row));
    residual = max_or_infinity(residual, abs(normal));
    if (layout_.lambda[place(row)] >= 0) residual = max_or_infinity(residual, friction_residual(row, z));
  }
  double worst = 0;
  for (std::size_t k = 0; k < residuals_.size(); ++k) {
    if (residuals_[k] <= error) continue;
    const double relative = to_double(residuals_[k] / scales_[k].value());
    if (!(relative <= worst)) worst = relative;
  }
  return worst;
}

}  // namespace lcpbench
