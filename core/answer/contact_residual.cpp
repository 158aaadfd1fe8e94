#include "core/answer/contact_residual.h"

#include <limits>

#include "core/answer/limits.h"

namespace lcpbench {
namespace {

Quad larger_or_infinity(Quad largest, Quad x) { return x <= largest ? largest : finite_or_infinity(x); }

}  // namespace

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
  Worst worst;
  const QuadVector errors = errors_of_islands(point);
  bool fails = false;  // whatever the errors are
  for (std::size_t island = 0; island < largest.size(); ++island) {
    const Quad scale = scales(model)[island], relative = quotient(largest[island], scale);
    const Quad error = errors.empty() ? Quad{0} : errors[island] / scale;
    const bool decides_itself = abs(relative - kSolvedVelocityResidual) > error || error == 0;
    worst.is_resolved = worst.is_resolved && error <= kResolvedError && decides_itself;
    fails = fails || relative - error > kSolvedVelocityResidual;
    if (largest[island] == 0) continue;
    worst.residual = larger(worst.residual, largest[island]);
    if (!(relative > worst.relative)) continue;
    worst.relative = relative;
    worst.row = row_of[island];
    worst.of_row = largest[island];
    worst.scale = scale;
  }
  worst.is_resolved = worst.is_resolved || fails;
  return worst;
}

/// How far the residual of each island may be off where the inertia has reduced rank; else empty. That of a round cone
/// or of the convex model adds up those of its three rows, each by the M of another.
QuadVector ContactResidual::errors_of_islands(const Point& point) {
  const QuadVector off = lcp->response_error(point.z);
  QuadVector errors(off.empty() ? 0 : rows_.count(), 0);
  for (std::size_t island = 0; island < errors.size(); ++island) {
    for (const std::size_t row : rows_.rows(island)) {
      errors[island] = larger_or_infinity(errors[island], lcp->residual_error(row, point.z, point.w[row], off));
    }
    if (cone) errors[island] *= 4;
  }
  return errors;
}

double ContactResidual::rho(const Point& point) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  if (!point.is_finite()) return kUnknown;
  const Worst worst = this->worst(FrictionModel::kPyramid, point);
  return worst.is_resolved ? to_double(worst.relative) : kUnknown;
}

}  // namespace lcpbench
