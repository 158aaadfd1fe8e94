#include "core/answer/contact_residual.h"

#include <limits>

#include "core/answer/limits.h"

namespace lcpbench {

ContactResidual::ContactResidual(const ContactProblem& contact)
    : problem(contact), inertia(contact.inertia), islands_(row_islands(contact)), rows_(islands_) {
  if (!inertia.well_defined()) return;
  lcp.emplace(contact, inertia);
  if (contact.frictional() && why_no_cone(contact).empty()) cone.emplace(contact, *lcp);
}

ContactResidual::Point ContactResidual::at(const Vector& z) const {
  Point point{numbers(z), {}, {}};
  point.u = lcp->response(point.z);
  point.w = lcp->all_rows(point.z, point.u);
  return point;
}

const QuadVector& ContactResidual::scales() {
  for (std::size_t k = scales_.size(); k < rows_.count(); ++k) {
    scales_.push_back(lcp->scale(rows_.rows(k), kSolvedVelocityResidual));
  }
  return scales_;
}

/// |min(M_ii z_i, w_i)|, of a cone row |min(lambda, M_nn w_i)|.
Quad ContactResidual::pyramid_row(std::size_t row, const Point& point) {
  const Quad z = point.z[row], w = point.w[row];
  if (inertia.has_inertia() && is_complementary(z, w)) return 0;  // no M_ii is negative
  // M_ii is needed only where its factor is not zero.
  const auto scaled = [this](std::size_t of, Quad factor) { return factor == 0 ? factor : lcp->diagonal(of) * factor; };
  return finite_or_infinity(row < lcp->impulses() ? row_residual(scaled(row, z), w)
                                                  : row_residual(z, scaled(lcp->normal_of_cone(row), w)));
}

ContactResidual::Worst ContactResidual::worst(FrictionModel model, const Point& point) {
  QuadVector largest(rows_.count(), 0);
  std::vector<Index> row_of(rows_.count(), -1);
  for_each_row(model, point, [&](Index row, Quad residual) {
    const auto island = static_cast<std::size_t>(islands_.of_row[static_cast<std::size_t>(row)]);
    if (!(residual > largest[island])) return;
    largest[island] = residual;
    row_of[island] = row;
  });
  Worst worst;
  for (std::size_t island = 0; island < largest.size(); ++island) {
    if (largest[island] == 0) continue;
    worst.residual = larger(worst.residual, largest[island]);
    const Quad scale = scales()[island], relative = quotient(largest[island], scale);
    if (!(relative > worst.relative)) continue;
    worst.relative = relative;
    worst.row = row_of[island];
    worst.of_row = largest[island];
    worst.scale = scale;
  }
  return worst;
}

double ContactResidual::rho(const Point& point) {
  const bool is_known = point.is_finite();
  const double rho = is_known ? to_double(worst(FrictionModel::kPyramid, point).relative) : 0;
  return is_known && inertia.well_defined() ? rho : std::numeric_limits<double>::infinity();
}

}  // namespace lcpbench
