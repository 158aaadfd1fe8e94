#include "core/answer/contact_residual.h"

#include <limits>

#include "core/answer/limits.h"

namespace lcpbench {

ContactResidual::ContactResidual(const ContactProblem& contact)
    : problem(contact), inertia(contact.inertia), islands_(row_islands(contact)), rows_(islands_) {
  if (!inertia.well_defined() && !inertia.unresolved()) return;
  lcp.emplace(contact, inertia);
  if (contact.frictional() && why_no_cone(contact).empty()) cone.emplace(contact, *lcp);
}

ContactResidual::Point ContactResidual::at(const Vector& z) const {
  Point point;
  point.z = numbers(z);
  point.u = lcp->response(point.z);
  point.w = lcp->all_rows(point.z, point.u);
  return point;
}

const QuadVector& ContactResidual::scales(FrictionModel model) {
  const bool convex = model == FrictionModel::kConvex;
  QuadVector& scales = convex ? convex_scales_ : scales_;
  if (scales.size() == rows_.count()) return scales;
  QuadVector without(convex ? rows_.count() : 0, 0);
  if (convex) {
    const Point point = at(Vector::Zero(static_cast<Index>(lcp->size())));
    for_each_row(model, point, [&](Index row, Quad residual) {
      Quad& largest = without[static_cast<std::size_t>(islands_.of_row[static_cast<std::size_t>(row)])];
      largest = larger(largest, residual);
    });
  }
  for (std::size_t k = 0; k < rows_.count(); ++k) {
    scales.push_back(convex ? lcp->scale(rows_.rows(k), without[k]) : lcp->scale(rows_.rows(k)));
  }
  return scales;
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
  Worst worst{.is_resolved = is_resolved(model, point)};
  for (std::size_t island = 0; island < largest.size(); ++island) {
    if (largest[island] == 0) continue;
    worst.residual = larger(worst.residual, largest[island]);
    const Quad scale = scales(model)[island], relative = quotient(largest[island], scale);
    if (!(relative > worst.relative)) continue;
    worst.relative = relative;
    worst.row = row_of[island];
    worst.of_row = largest[island];
    worst.scale = scale;
  }
  return worst;
}

bool ContactResidual::is_resolved(FrictionModel model, const Point& point) {
  const QuadVector off = lcp->response_error(point.z);
  for (std::size_t island = 0; !off.empty() && island < rows_.count(); ++island) {
    const Quad most = Quad{kResolvedError} * scales(model)[island];
    for (const std::size_t row : rows_.rows(island)) {
      if (!(lcp->residual_error(row, point.z, point.w[row], off) <= most)) return false;
    }
  }
  return true;
}

double ContactResidual::rho(const Point& point) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  if (!point.is_finite()) return kUnknown;
  const Worst worst = this->worst(FrictionModel::kPyramid, point);
  return worst.is_resolved ? to_double(worst.relative) : kUnknown;
}

}  // namespace lcpbench
