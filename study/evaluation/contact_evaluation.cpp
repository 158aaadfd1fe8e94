#include "study/evaluation/contact_evaluation.h"

#include <algorithm>
#include <limits>

#include "study/evaluation/returned_velocity.h"

namespace lcpbench {

Errors ContactEvaluation::errors(const Answer& answer, FrictionModel model) {
  Errors errors;
  errors.usable = true;
  const RefinedInertia& inertia = contact_.inertia;
  const bool has_model = model == FrictionModel::kPyramid || contact_.cone;
  const bool is_known = contact_.lcp && measure(answer, has_model ? model : FrictionModel::kPyramid, errors);
  if (!is_known) {
    errors = {};
    errors.usable = true;
  } else if (!has_model) {
    for (double Errors::*const measure :
         {&Errors::natural_residual, &Errors::complementarity_j, &Errors::velocity_residual_m_per_s,
          &Errors::velocity_residual_relative, &Errors::contact_residual_m_per_s, &Errors::cone_violation,
          &Errors::forward_velocity}) {
      errors.*measure = Errors::kNone;
    }
    errors.worst = {};
    errors.worst_bounded_row = {};
    errors.solved = false;
  } else if (model == FrictionModel::kConvex) {
    errors.optimum_distance = optimum_distance(answer.z);
  }
  errors.unresolved = is_known ? !has_model : inertia.unresolved() || inertia.well_defined();
  return errors;
}

/// @returns false where 113 bits do not tell G* well enough. No impulses need no G*, where nothing violates them.
bool ContactEvaluation::measure(const Answer& answer, FrictionModel model, Errors& errors) {
  const ContactResidual::Point point = contact_.at(answer.z);
  if (!point.is_finite()) return contact_.inertia.well_defined();
  const auto& [z, u, w] = point;
  const ContactLcp& lcp = *contact_.lcp;
  const bool pyramid = model == FrictionModel::kPyramid;
  const auto one_sided = static_cast<Index>(lcp.first_bounded());  // rows of z >= 0
  errors.min_z = one_sided == 0 ? 0 : answer.z.head(one_sided).minCoeff();
  const ContactResidual::Worst worst = contact_.worst(model, point);
  if (!worst.is_resolved) return false;
  errors.velocity_residual_m_per_s = to_double(worst.residual);
  errors.velocity_residual_relative = to_double(worst.relative);
  if (worst.row >= 0) errors.worst = describe(worst, model, point);
  errors.contact_residual_m_per_s = to_double(worst.of_contacts);
  if (const Index row = worst.bounded_row; row >= 0) {
    const auto i = static_cast<std::size_t>(row);
    errors.worst_bounded_row = {row - static_cast<Index>(lcp.first_bounded()),
                                to_double(contact_.lcp->bounded_residual(i, z, w[i]))};
  }
  errors.decide(kSolvedVelocityResidual);
  if (!contact_.inertia.well_defined() && !errors.solved) return false;
  if (contact_.cone) {
    errors.model_error_m_per_s = model == FrictionModel::kCone
                                     ? errors.velocity_residual_m_per_s
                                     : to_double(contact_.worst(FrictionModel::kCone, point).residual);
  }
  Quad violation = 0, cone_violation = 0;
  for (std::size_t i = 0; i < lcp.contacts(); ++i) violation = larger(violation, -w[i]);
  if (pyramid) {
    for (std::size_t i = lcp.impulses(); i < lcp.first_bounded(); ++i) cone_violation = larger(cone_violation, -w[i]);
    if (!contact_.problem.has_rows()) {
      Quad natural = 0;
      for (std::size_t i = 0; i < z.size(); ++i) natural = larger(natural, row_residual(z[i], w[i]));
      errors.natural_residual = to_double(natural);
      errors.complementarity_j = to_double(complementarity(z, w));
    }
    errors.forward_velocity = forward_velocity(u);
  } else {
    for (Index contact = 0; contact < contact_.problem.nc(); ++contact) {
      if (contact_.cone->has_friction(contact)) {
        cone_violation = larger(cone_violation, -contact_.cone->slack(contact, z));
      }
    }
  }
  errors.violation_m_per_s = to_double(violation);
  errors.cone_violation = to_double(cone_violation);
  errors.work_gain_j = work_gain(point);
  const double work = -to_double(lcp.offset_work(z));  // that a solution may gain by the offsets of its rows
  errors.criterion =
      errors.work_gain_j - work < kCriterionWork && errors.violation_m_per_s < kCriterionViolation;
  return ReturnedVelocity(contact_, z, u).measure(answer.velocity, errors);
}

WorstRow ContactEvaluation::describe(const ContactResidual::Worst& worst, FrictionModel model,
                                     const ContactResidual::Point& point) {
  const ContactLayout& layout = contact_.lcp->layout();
  const auto row = static_cast<std::size_t>(worst.row);
  WorstRow worst_row{.row = worst.row,
                     .z = to_double(point.z[row]),
                     .w = to_double(point.w[row]),
                     .residual = to_double(worst.of_row),
                     .scale = to_double(worst.scale)};
  if (worst.row >= layout.row_offset()) {
    worst_row.in_own_unit = to_double(contact_.lcp->bounded_residual(row, point.z, point.w[row]));
    return worst_row;
  }
  if (worst.row < layout.lambda_offset()) return worst_row;
  const Index contact = layout.cone_contact[static_cast<std::size_t>(worst.row - layout.lambda_offset())];
  if (model == FrictionModel::kPyramid) {
    const auto first = point.w.begin() + layout.friction_offset();
    const auto c = static_cast<std::size_t>(contact);
    worst_row.slip = to_double(
        point.z[row] - *std::min_element(first + layout.friction_begin[c], first + layout.friction_begin[c + 1]));
    return worst_row;
  }
  const ConeFriction& cone = *contact_.cone;
  const ConeFriction::Vector2 f = cone.impulse(contact, point.z), slip = cone.slip(contact, point.z, point.u);
  worst_row.z = to_double(cone.speed(contact, point.u));
  worst_row.w = to_double(cone.slack(contact, point.z));
  worst_row.slip = to_double(slip.length());
  worst_row.separation = to_double(cone.separation(contact, point.z, point.u));
  worst_row.normal = to_double(point.z[static_cast<std::size_t>(contact)]);
  worst_row.friction = to_double(f.length());
  worst_row.opposing = -to_double(quotient(f.dot(slip), f.length() * slip.length()));
  return worst_row;
}

/// With G (v+ - v) = G G* J f: the part of J f in the range of G.
double ContactEvaluation::work_gain(const ContactResidual::Point& point) const {
  const ContactLcp& lcp = *contact_.lcp;
  if (lcp.at_rest(point.z)) return 0;
  QuadVector momentum = lcp.generalized_impulse(point.z);
  if (contact_.inertia.is_cut()) {  // its range is not that of G
    contact_.inertia.solve(momentum);
    momentum = contact_.inertia.apply(momentum);
  } else {
    momentum = difference(momentum, contact_.inertia.outside_range(momentum));
  }
  return to_double((inner(momentum, point.u) + inner(momentum, lcp.velocity_before())) / 2);
}

double ContactEvaluation::forward_velocity(const Vector& z) const {
  if (!contact_.lcp) return Errors::kNone;
  const QuadVector v_plus = contact_.lcp->response(numbers(z));
  return all_finite(v_plus) ? forward_velocity(v_plus) : Errors::kNone;
}

double ContactEvaluation::forward_velocity(const QuadVector& velocity) const {
  const RefinedInertia& inertia = contact_.inertia;
  if (!v_star_ || !inertia.has_inertia()) return Errors::kNone;
  const QuadVector apart = difference(velocity, *v_star_);
  const QuadVector& v = contact_.lcp->velocity_before();
  return to_double(quotient(sqrt(inner(apart, inertia.apply(apart))), sqrt(inner(v, inertia.apply(v)))));
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
/// than 4 edges, whose directions are sums of the tangents only to rounding, and with bounded rows.
double ContactEvaluation::optimum_distance(const Vector& impulses) {
  constexpr double kUnbounded = std::numeric_limits<double>::infinity();
  const ContactProblem& problem = contact_.problem;
  if (problem.has_rows()) return Errors::kNone;
  const auto has_more_edges = [](int edges) { return edges > 4; };
  if (std::any_of(problem.edges.begin(), problem.edges.end(), has_more_edges)) return Errors::kNone;
  if (!contact_.lcp || !contact_.inertia.has_inertia() || !proven_positive_definite()) return kUnbounded;
  ContactLcp& lcp = *contact_.lcp;
  const ConeFriction friction(problem, lcp);
  const ContactLayout& layout = lcp.layout();
  const QuadVector given = numbers(impulses);
  QuadVector z = given;  // shortened until it is in the cones
  for (Index contact = 0; contact < layout.nc; ++contact) {
    const auto row = static_cast<std::size_t>(contact);
    z[row] = larger(z[row], 0);
    if (!friction.has_friction(contact)) continue;
    const Quad most = problem.mu(contact) * z[row], length = friction.impulse(contact, z).length();
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

}  // namespace lcpbench
