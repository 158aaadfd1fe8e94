#include "study/evaluation/friction_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/islands.h"
#include "study/evaluation/cone_friction.h"

namespace lcpbench {
namespace {

Quad normal_residual(ContactQuadLcp& lcp, std::size_t row, Quad f_N, Quad w) {
  const Quad residual = abs(smaller(f_N == 0 ? Quad{0} : lcp.diagonal(row) * f_N, w));
  return is_finite(residual) ? residual : Quad{std::numeric_limits<double>::infinity()};
}

void measure_by_cone(const ContactProblem& problem, const QuadInertia& inertia, const Vector& impulses,
                     Errors& errors) {
  ContactQuadLcp lcp(problem, inertia);
  const ConeFriction<Quad> friction(problem, lcp);
  const ContactLayout layout = contact_layout(problem);
  const QuadVector z(impulses.begin(), impulses.end());
  const QuadVector u = lcp.response(z);
  const RowIslands islands = row_islands(problem);
  std::vector<Quad> scale(static_cast<std::size_t>(islands.count), 0);
  const auto of_row = [&](Index row) {
    return static_cast<std::size_t>(islands.of_row[static_cast<std::size_t>(row)]);
  };
  for (std::size_t row = 0; row < lcp.impulses(); ++row) {
    Quad& largest = scale[of_row(static_cast<Index>(row))];
    largest = larger(largest, larger(abs(lcp.q(row)), lcp.formation_error(row) / kSolvedVelocityResidual));
  }
  Quad largest = 0;
  Quad rho = 0;
  errors.worst = {};
  const auto take = [&](const WorstRow& row, Quad residual) {
    largest = larger(largest, residual);
    const Quad relative = quotient(residual, scale[of_row(row.row)]);
    if (!(relative > rho)) return;
    rho = relative;
    errors.worst = row;
    errors.worst.residual = to_double(residual);
    errors.worst.scale = to_double(scale[of_row(row.row)]);
  };
  Quad excess = 0;
  for (Index contact = 0; contact < layout.nc; ++contact) {
    const auto row = static_cast<std::size_t>(contact);
    const Quad w = lcp.row(row, z, u);
    take({.row = contact, .z = impulses(contact), .w = to_double(w)}, normal_residual(lcp, row, z[row], w));
    if (!friction.has_friction(contact)) continue;
    const Quad slack = friction.slack(contact, z);
    excess = larger(excess, -slack);
    take({.row = layout.lambda_offset() + layout.lambda[row],
          .z = to_double(friction.slip(contact, u)),
          .w = to_double(slack)},
         friction.residual(contact, z, u));
  }
  errors.velocity_residual_m_per_s = to_double(largest);
  errors.model_error_m_per_s = errors.velocity_residual_m_per_s;
  errors.velocity_residual_relative = to_double(rho);
  errors.cone_violation = to_double(excess);
  errors.solved = errors.velocity_residual_relative <= kSolvedVelocityResidual &&
                  std::isfinite(errors.velocity_residual_m_per_s) && errors.velocity_passes();
}

}  // namespace

const char* to_string(FrictionModel model) { return model == FrictionModel::kCone ? "cone" : "pyramid"; }

FrictionModel friction_model(FrictionModel of_solver, const Problem& problem) {
  const ContactProblem* contact = problem.contact();
  return contact != nullptr && contact->frictional() ? of_solver : FrictionModel::kPyramid;
}

void measure_cone(const Problem& problem, const Answer& answer, Errors& errors) {
  const ContactProblem* contact = problem.contact();
  if (contact == nullptr || !contact->frictional() || !errors.usable) return;
  for (double Errors::*const measure :
       {&Errors::natural_residual, &Errors::forward_velocity, &Errors::complementarity_j, &Errors::velocity_residual_m_per_s,
        &Errors::velocity_residual_relative, &Errors::model_error_m_per_s, &Errors::cone_violation}) {
    errors.*measure = Errors::kNone;
  }
  errors.worst = {};
  errors.solved = false;
  const bool round =
      std::all_of(contact->edges.begin(), contact->edges.end(), [](int edges) { return edges % 4 == 0; });
  const QuadInertia inertia(contact->inertia);
  errors.unresolved = inertia.unresolved();
  if (!round || !inertia.well_defined() || !contact->v.allFinite() || !all_finite(contact->N) ||
      !all_finite(contact->D)) {
    return;
  }
  measure_by_cone(*contact, inertia, answer.z, errors);
}

}  // namespace lcpbench
