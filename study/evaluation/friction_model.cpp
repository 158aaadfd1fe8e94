#include "study/evaluation/friction_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory_resource>

#include "core/islands.h"
#include "core/round_cone.h"
#include "study/evaluation/cone_friction.h"
#include "study/evaluation/contact_evaluation.h"
#include "study/evaluation/measures.h"

namespace lcpbench {
namespace {

void measure_by_cone(ContactEvaluation<Quad>& evaluation, const RowIslands& islands, const Vector& impulses, bool convex,
                     Errors& errors) {
  ContactLcp<Quad>& lcp = *evaluation.lcp;
  const ConeFriction<Quad> friction(evaluation.problem, lcp);
  const ContactLayout& layout = lcp.layout();
  const QuadVector z(impulses.begin(), impulses.end());
  QuadVector u, rows;
  errors.unresolved = !evaluation.respond(impulses, z, u, rows);
  if (errors.unresolved) return;
  // Where respond() needed exact arithmetic, the diagonal of M comes from it, too.
  for (std::size_t row = 0; row < lcp.impulses() && evaluation.exact; ++row) {
    if (lcp.representative(row) == row) lcp.set_diagonal(row, evaluation.diagonal(row));
  }
  Quad largest = 0;
  Quad rho = 0;
  errors.worst = {};
  const auto take = [&](const WorstRow& row, Quad residual) {
    largest = larger(largest, residual);
    const auto island = static_cast<std::size_t>(islands.of_row[static_cast<std::size_t>(row.row)]);
    const Quad scale = evaluation.scales()[island];
    const Quad relative = quotient(residual, scale);
    if (!(relative > rho)) return;
    rho = relative;
    errors.worst = row;
    errors.worst.residual = to_double(residual);
    errors.worst.scale = to_double(scale);
  };
  Quad excess = 0;
  for (Index contact = 0; contact < layout.nc; ++contact) {
    const auto row = static_cast<std::size_t>(contact);
    const Quad w = rows[row];
    if (!convex || !friction.has_friction(contact)) {
      take({.row = contact, .z = impulses(contact), .w = to_double(w)}, evaluation.row_residual(row, z, rows));
    }
    if (!friction.has_friction(contact)) continue;
    const Quad slack = friction.slack(contact, z);
    excess = larger(excess, -slack);
    take({.row = layout.lambda_offset() + layout.lambda[row],
          .z = to_double(friction.slip(contact, u)),
          .w = to_double(slack)},
         convex ? friction.convex_residual(contact, z, u) : friction.residual(contact, z, u));
  }
  if (const Index cone = errors.worst.row - layout.lambda_offset(); cone >= 0) {
    friction.describe(layout.cone_contact[static_cast<std::size_t>(cone)], z, u, errors.worst);
  }
  errors.velocity_residual_m_per_s = to_double(largest);
  if (!convex) errors.model_error_m_per_s = errors.velocity_residual_m_per_s;
  errors.velocity_residual_relative = to_double(rho);
  errors.cone_violation = to_double(excess);
  errors.decide(kSolvedVelocityResidual);
}

/// An upper bound of |v+ - v*|_G / |v+ - v|_G for an answer to the convex model, v* the velocity of the optimum.
/// Rounding is included in the bound.
///
/// Let f be in the cones, w = J'v+ + b + R f, and lack >= 0, along the normals, the least such that w + lack is in the
/// dual cones. With s = R f + lack, the primal energy 1/2 |v+ - v|_G^2 + 1/2 |s|_{1/R}^2 exceeds the dual one, that of
/// f, by f'w + f_N'lack + 1/2 lack'lack / r_n. This gap is at least |v+ - v*|_G^2, as both energies are strongly convex
/// in the velocity. Impulses outside of their cones are first shortened, and the change of velocity is added.
///
/// Infinite where a contact without compliance has a lack, where rounding leaves open whether a shortened impulse is in
/// its cone, and where G is not proven positive definite. NaN for more than 4 edges, whose directions are sums of the
/// tangents only to rounding. @pre why_no_round_cone() is ""
double optimum_distance(const ContactProblem& problem, const Vector& impulses) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kInside = 1 - 0x1p-45;
  const auto has_more_edges = [](int edges) { return edges > 4; };
  if (std::any_of(problem.edges.begin(), problem.edges.end(), has_more_edges)) return Errors::kNone;
  const BoundedInertia inertia(problem.inertia);
  if (!inertia.well_defined() || !inertia.proven_positive_definite()) return kInfinity;
  ContactLcp<Bounded> lcp(problem, inertia);
  const ConeFriction<Bounded> friction(problem, lcp);
  const ContactLayout& layout = lcp.layout();
  const BoundedVector given(impulses.begin(), impulses.end());
  BoundedVector z = given;  // shortened until it is surely in the cones
  for (Index contact = 0; contact < layout.nc; ++contact) {
    const auto row = static_cast<std::size_t>(contact);
    if (z[row].high < 0) z[row] = 0;
    if (!friction.has_friction(contact)) continue;
    const double most = problem.mu(contact) * z[row].high;
    const double length = friction.impulse(contact, z).high;
    const double share = length > kInside * most ? kInside * most / length : 1.0;
    for (Index j = layout.friction_begin[row]; j < layout.friction_begin[row + 1]; ++j) {
      auto& each = z[static_cast<std::size_t>(layout.friction_offset() + j)];
      if (share != 1) each = Bounded(share) * each;
    }
    if (!surely_at_most(friction.impulse(contact, z), Bounded(problem.mu(contact)) * z[row])) return kInfinity;
  }
  const BoundedVector u = lcp.response(z), moved = lcp.response(given);
  Bounded gap = 0;
  for (Index contact = 0; contact < layout.nc; ++contact) {
    const auto row = static_cast<std::size_t>(contact);
    const Bounded w = lcp.row(row, z, u);
    const bool frictional = friction.has_friction(contact);
    const Bounded lack = larger(frictional ? friction.lack(contact, z, u) : -w, 0.0);
    gap += frictional ? friction.work(contact, z, u) : z[row] * w;
    if (surely_equal(lack, 0)) continue;
    const double compliance = problem.normal_compliance(contact);
    if (compliance == 0) return kInfinity;
    gap += z[row] * lack + lack * lack / Bounded(2 * compliance);
  }
  // The distance from the answer to the velocity of the shortened impulses, and from that to the optimum.
  const auto energy = [&](const BoundedVector& impulse, const BoundedVector& change) {
    Bounded sum = 0;
    for (std::size_t i = 0; i < change.size(); ++i) sum += impulse[i] * change[i];
    return sum;
  };
  const BoundedVector own = lcp.generalized_impulse(given), inside = lcp.generalized_impulse(z);
  const auto largest_root = [](const Bounded& x) {
    const double largest = x.high + std::abs(x.low) + 2 * x.error;
    return std::isnan(largest) ? kInfinity : std::sqrt(std::max(0.0, largest));
  };
  const double distance = largest_root(gap) + largest_root(energy(difference(own, inside), difference(moved, u)));
  const Bounded whole = energy(own, difference(moved, lcp.velocity_before()));
  const double least = std::sqrt(std::max(0.0, whole.high - std::abs(whole.low) - 2 * whole.error));
  return distance == 0 ? 0 : std::nextafter(distance * (1 + 0x1p-50) / least, kInfinity);
}

}  // namespace

FrictionModel friction_model(FrictionModel of_solver, const Problem& problem) {
  const ContactProblem* contact = problem.contact();
  return contact != nullptr && contact->frictional() ? of_solver : FrictionModel::kPyramid;
}

void measure_friction(FrictionModel model, const Problem& problem, const Answer& answer, Errors& errors) {
  const ContactProblem* contact = problem.contact();
  const bool convex = model == FrictionModel::kConvex;
  if (contact == nullptr || !errors.usable) return;
  const bool finite = why_not({}, problem).empty();  // no NaN, no infinity
  if (!contact->frictional()) {  // all models are the same
    if (contact->is_soft() && finite) errors.optimum_distance = optimum_distance(*contact, answer.z);
    return;
  }
  if (model == FrictionModel::kPyramid) return;
  for (double Errors::*const measure :
       {&Errors::natural_residual, &Errors::forward_velocity, &Errors::complementarity_j, &Errors::velocity_residual_m_per_s,
        &Errors::velocity_residual_relative, &Errors::cone_violation}) {
    errors.*measure = Errors::kNone;
  }
  if (!convex) errors.model_error_m_per_s = Errors::kNone;
  errors.worst = {};
  errors.solved = false;
  if (!finite) return;
  const RowIslands islands = row_islands(*contact);
  const IslandRows rows(islands);
  ContactEvaluation<Quad> evaluation(*contact, rows, std::pmr::get_default_resource());
  errors.unresolved = evaluation.inertia.unresolved() || !why_no_round_cone(*contact).empty();
  if (!evaluation.lcp || errors.unresolved) return;
  measure_by_cone(evaluation, islands, answer.z, convex, errors);
  if (convex) errors.optimum_distance = optimum_distance(*contact, answer.z);
}

}  // namespace lcpbench
