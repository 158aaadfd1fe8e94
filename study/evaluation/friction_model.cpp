#include "study/evaluation/friction_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/islands.h"
#include "core/round_cone.h"
#include "study/evaluation/cone_friction.h"
#include "study/evaluation/contact_evaluation.h"
#include "study/evaluation/measures.h"

namespace lcpbench {
namespace {

void measure_by_cone(ContactEvaluation& evaluation, const RowIslands& islands, const Vector& impulses, bool convex,
                     Errors& errors) {
  ContactLcp& lcp = *evaluation.lcp;
  const ConeFriction friction(evaluation.problem, lcp);
  const ContactLayout& layout = lcp.layout();
  const QuadVector z = numbers(impulses), u = lcp.response(z), rows = lcp.all_rows(z, u);
  if (!all_finite(rows) || !all_finite(u)) return;
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

/// |v+ - v*|_G / |v+ - v|_G or more, but for rounding in 113 bits, for an answer to the convex model, v* the velocity
/// of the optimum.
///
/// Let f be in the cones, w = J'v+ + b + R f, and lack >= 0, along the normals, the least such that w + lack is in the
/// dual cones. With s = R f + lack, the primal energy 1/2 |v+ - v|_G^2 + 1/2 |s|_{1/R}^2 exceeds the dual one, that of
/// f, by f'w + f_N'lack + 1/2 lack'lack / r_n. This gap is at least |v+ - v*|_G^2, as both energies are strongly convex
/// in the velocity. Impulses outside of their cones are first shortened, and the change of velocity is added.
///
/// Infinite where a contact without compliance has a lack, and where G is not proven positive definite. NaN for more
/// than 4 edges, whose directions are sums of the tangents only to rounding. @pre why_no_cone() is ""
double optimum_distance(const ContactEvaluation& evaluation, const Vector& impulses) {
  constexpr double kUnbounded = std::numeric_limits<double>::infinity();
  const ContactProblem& problem = evaluation.problem;
  const RefinedInertia& inertia = evaluation.inertia;
  const auto has_more_edges = [](int edges) { return edges > 4; };
  if (std::any_of(problem.edges.begin(), problem.edges.end(), has_more_edges)) return Errors::kNone;
  if (!evaluation.lcp || !inertia.has_inertia() || !inertia.proven_positive_definite()) return kUnbounded;
  ContactLcp lcp(problem, inertia);
  const ConeFriction friction(problem, lcp);
  const ContactLayout& layout = lcp.layout();
  const QuadVector given = numbers(impulses);
  QuadVector z = given;  // shortened until it is in the cones
  for (Index contact = 0; contact < layout.nc; ++contact) {
    const auto row = static_cast<std::size_t>(contact);
    z[row] = larger(z[row], 0);
    if (!friction.has_friction(contact)) continue;
    const Quad most = problem.mu(contact) * z[row], length = friction.impulse(contact, z);
    for (Index j = layout.friction_begin[row]; length > most && j < layout.friction_begin[row + 1]; ++j) {
      z[static_cast<std::size_t>(layout.friction_offset() + j)] *= most / length;
    }
  }
  const QuadVector u = lcp.response(z), moved = lcp.response(given), w = lcp.all_rows(z, u);
  Quad gap = 0;
  for (Index contact = 0; contact < layout.nc; ++contact) {
    const auto row = static_cast<std::size_t>(contact);
    const bool frictional = friction.has_friction(contact);
    const Quad lack = larger(frictional ? friction.lack(contact, z, u) : -w[row], 0);
    gap += frictional ? friction.work(contact, z, u) : z[row] * w[row];
    if (lack == 0) continue;
    const double compliance = problem.normal_compliance(contact);
    if (compliance == 0) return kUnbounded;
    gap += z[row] * lack + lack * lack / (2 * compliance);
  }
  // The distance from the answer to the velocity of the shortened impulses, and from that to the optimum.
  const QuadVector own = lcp.generalized_impulse(given), inside = lcp.generalized_impulse(z);
  const Quad distance = sqrt(gap) + sqrt(inner(difference(own, inside), difference(moved, u)));
  return to_double(quotient(distance, sqrt(inner(own, difference(moved, lcp.velocity_before())))));
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
  if (!contact->frictional()) {                      // all models are the same
    if (!contact->is_soft() || !finite) return;
    const IslandRows rows(row_islands(*contact));
    ContactEvaluation evaluation(*contact, rows);
    errors.optimum_distance = optimum_distance(evaluation, answer.z);
    return;
  }
  if (model == FrictionModel::kPyramid) return;
  for (double Errors::*const measure :
       {&Errors::natural_residual, &Errors::forward_velocity, &Errors::complementarity_j,
        &Errors::velocity_residual_m_per_s, &Errors::velocity_residual_relative, &Errors::cone_violation}) {
    errors.*measure = Errors::kNone;
  }
  if (!convex) errors.model_error_m_per_s = Errors::kNone;
  errors.worst = {};
  errors.solved = false;
  if (!finite) return;
  const RowIslands islands = row_islands(*contact);
  const IslandRows rows(islands);
  ContactEvaluation evaluation(*contact, rows);
  errors.unresolved = evaluation.inertia.unresolved() || !why_no_cone(*contact).empty();
  if (!evaluation.lcp || errors.unresolved) return;
  const Errors unmeasured = errors;
  measure_by_cone(evaluation, islands, answer.z, convex, errors);
  if (!evaluation.inertia.well_defined()) errors = unmeasured;  // see Evaluator::errors()
  errors.unresolved = evaluation.inertia.unresolved();
  if (errors.unresolved) return;
  if (convex) errors.optimum_distance = optimum_distance(evaluation, answer.z);
}

}  // namespace lcpbench
