#include "study/evaluation/contact_evaluation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "study/evaluation/measures.h"

namespace lcpbench {

const QuadVector& ContactEvaluation::scales() {
  for (std::size_t k = scales_.size(); k < islands.count(); ++k) scales_.push_back(lcp->scale(islands.rows(k)));
  return scales_;
}

Quad ContactEvaluation::row_residual(std::size_t row, const QuadVector& z, const QuadVector& w) {
  if (inertia.has_inertia() && is_complementary(z[row], w[row])) return 0;  // no M_ii is negative
  // M_ii is needed only where its factor is not zero.
  const auto scaled = [this](std::size_t of, Quad factor) { return factor == 0 ? factor : lcp->diagonal(of) * factor; };
  const Quad residual = row < lcp->impulses() ? abs(smaller(scaled(row, z[row]), w[row]))
                                              : abs(smaller(z[row], scaled(lcp->normal_of_cone(row), w[row])));
  return is_finite(residual) ? residual : Quad{std::numeric_limits<double>::infinity()};
}

/// Returns the residuals of all rows.
QuadVector ContactEvaluation::measure_residual(const QuadVector& z, const QuadVector& w, Errors& errors) {
  Quad largest = 0;
  Quad rho = 0;
  QuadVector residuals(z.size());
  for (std::size_t island = 0; island < islands.count(); ++island) {
    Quad residual = 0;
    std::size_t worst = 0;
    for (const std::size_t row : islands.rows(island)) {
      residuals[row] = row_residual(row, z, w);
      if (residuals[row] > residual) worst = row;
      residual = larger(residual, residuals[row]);
    }
    largest = larger(largest, residual);
    if (residual == 0) continue;
    const Quad scale = scales()[island];
    const Quad relative = quotient(residual, scale);
    if (!(relative > rho)) continue;
    rho = relative;
    errors.worst = {static_cast<Index>(worst), to_double(z[worst]), to_double(w[worst]), to_double(residual),
                    to_double(scale)};
  }
  if (errors.worst.row >= static_cast<Index>(lcp->impulses())) {
    const ContactLayout& layout = lcp->layout();
    const auto worst = static_cast<std::size_t>(errors.worst.row);
    const auto contact = static_cast<std::size_t>(layout.cone_contact[worst - lcp->impulses()]);
    const auto first = w.begin() + layout.friction_offset();
    errors.worst.slip = to_double(z[worst] - *std::min_element(first + layout.friction_begin[contact],
                                                               first + layout.friction_begin[contact + 1]));
  }
  errors.velocity_residual_m_per_s = to_double(largest);
  errors.velocity_residual_relative = to_double(rho);
  errors.decide(kSolvedVelocityResidual);
  return residuals;
}

/// The cone shares the normal rows with the pyramid.
double ContactEvaluation::model_error(const QuadVector& z, const QuadVector& v_plus, const QuadVector& residuals) {
  if (!cone) return Errors::kNone;
  Quad largest = 0;
  for (Index contact = 0; contact < problem.nc(); ++contact) {
    largest = larger(largest, residuals[static_cast<std::size_t>(contact)]);
    if (cone->has_friction(contact)) largest = larger(largest, cone->residual(contact, z, v_plus));
  }
  return to_double(largest);
}

/// With G (v+ - v) = G G* J f: the part of J f in the range of G.
Quad ContactEvaluation::work_gain(const QuadVector& z, const QuadVector& v_plus) const {
  if (lcp->at_rest(z)) return 0;
  QuadVector momentum = lcp->generalized_impulse(z);
  if (inertia.is_cut()) {  // its range is not that of G
    inertia.solve(momentum);
    momentum = inertia.apply(momentum);
  } else {
    momentum = difference(momentum, inertia.outside_range(momentum));
  }
  return (inner(momentum, v_plus) + inner(momentum, lcp->velocity_before())) / 2;
}

void ContactEvaluation::measure(const QuadVector& z, const QuadVector& v_plus, const QuadVector& w, Errors& errors) {
  const QuadVector residuals = measure_residual(z, w, errors);
  errors.model_error_m_per_s = model_error(z, v_plus, residuals);
  Quad violation = 0, cone_violation = 0;
  for (std::size_t i = 0; i < lcp->contacts(); ++i) violation = larger(violation, -w[i]);
  for (std::size_t i = lcp->impulses(); i < lcp->size(); ++i) cone_violation = larger(cone_violation, -w[i]);
  errors.violation_m_per_s = to_double(violation);
  errors.cone_violation = to_double(cone_violation);
  errors.work_gain_j = to_double(work_gain(z, v_plus));
  errors.forward_velocity = forward_velocity(v_plus);

  Quad work = 0;  // that a solution may gain by the offsets of its rows
  for (std::size_t i = 0; i < lcp->offsets(); ++i) work -= lcp->offset(i) * z[i];
  errors.criterion =
      errors.work_gain_j - to_double(work) < kCriterionWork && errors.violation_m_per_s < kCriterionViolation;
}

double ContactEvaluation::forward_velocity(const QuadVector& velocity) const {
  if (!v_star || !inertia.has_inertia()) return Errors::kNone;
  const QuadVector apart = difference(velocity, *v_star);
  const QuadVector& v = lcp->velocity_before();
  return to_double(quotient(sqrt(inner(apart, inertia.apply(apart))), sqrt(inner(v, inertia.apply(v)))));
}

}  // namespace lcpbench
