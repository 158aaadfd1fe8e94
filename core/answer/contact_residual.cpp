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

void ContactResidual::set_velocity(const Vector& v) {
  if (lcp) lcp->set_velocity(v);
  scales_.clear();
  convex_scales_.clear();
}

void ContactResidual::take(const Vector& z, Point& point) const {
  point.z.assign(z.begin(), z.end());
  lcp->respond(point.z, point.u);
  lcp->write_rows(point.z, point.u, point.w);
}

void ContactResidual::complete(Vector& z, Point& point) const {
  point.z.assign(z.begin(), z.end());
  lcp->respond(point.z, point.u);
  lcp->complete(point.z, point.u);
  for (std::size_t i = lcp->impulses(); i < lcp->first_bounded(); ++i) z(static_cast<Index>(i)) = to_double(point.z[i]);
  lcp->write_rows(point.z, point.u, point.w);
}

const QuadVector& ContactResidual::scales(FrictionModel model) {
  const bool convex = model == FrictionModel::kConvex;
  QuadVector& scales = convex ? convex_scales_ : scales_;
  if (scales.size() == rows_.count()) return scales;
  without_.assign(convex ? rows_.count() : 0, 0);
  if (convex) {
    rest_.z.assign(lcp->size(), 0);
    lcp->respond(rest_.z, rest_.u);
    lcp->write_rows(rest_.z, rest_.u, rest_.w);
    for_each_row(model, rest_, [&](Index row, Quad residual) {
      Quad& largest = without_[static_cast<std::size_t>(islands_.of_row[static_cast<std::size_t>(row)])];
      largest = larger(largest, residual);
    });
  }
  for (std::size_t k = 0; k < rows_.count(); ++k) {
    scales.push_back(convex ? lcp->scale(rows_.rows(k), without_[k]) : lcp->scale(rows_.rows(k)));
  }
  return scales;
}

/// Of a bounded row.
Quad ContactResidual::bounded_row(std::size_t row, const Point& point) {
  const Quad residual = lcp->bounded_residual(row, point.z, point.w[row]);
  return residual == 0 ? residual : finite_or_infinity(lcp->lever(row) * residual);
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

/// largest_ and row_of_, the first of equal rows. Of the pyramid the rows without M_ii come first: others, of which
/// |min(M_ii z_i, w_i)| <= w_i, need M_ii only where w_i is larger than the largest residual.
void ContactResidual::find_largest(FrictionModel model, const Point& point) {
  largest_.assign(rows_.count(), 0);
  row_of_.assign(rows_.count(), -1);
  const auto island = [this](Index row) {
    return static_cast<std::size_t>(islands_.of_row[static_cast<std::size_t>(row)]);
  };
  const bool has_rows = problem.has_rows();
  of_contacts_ = of_bounded_ = 0;
  bounded_row_ = -1;
  const auto note = [&](Index row, Quad residual) {
    if (has_rows) note_kind(row, residual);
    Quad& largest = largest_[island(row)];
    Index& row_of = row_of_[island(row)];
    if (!(residual > largest || (residual == largest && row < row_of))) return;
    largest = residual;
    row_of = row;
  };
  if (model != FrictionModel::kPyramid) return for_each_row(model, point, note);
  for (const bool with_diagonal : {false, true}) {
    for (std::size_t row = 0; row < lcp->first_bounded(); ++row) {
      const auto index = static_cast<Index>(row);
      const Quad upper_bound = row < lcp->impulses() ? point.w[row] : point.z[row];
      const Quad factor = row < lcp->impulses() ? point.z[row] : point.w[row];  // of M_ii
      const bool needs_diagonal = factor > 0 && upper_bound > 0;
      if (needs_diagonal != with_diagonal || (needs_diagonal && upper_bound < largest_[island(index)])) continue;
      note(index, pyramid_row(row, point));
    }
  }
  for (std::size_t row = lcp->first_bounded(); row < lcp->size(); ++row) {
    note(static_cast<Index>(row), bounded_row(row, point));
  }
}

/// of_contacts_ and of_bounded_.
void ContactResidual::note_kind(Index row, Quad residual) {
  if (!lcp->is_bounded(static_cast<std::size_t>(row))) {
    of_contacts_ = larger(of_contacts_, residual);
  } else if (residual > of_bounded_) {
    of_bounded_ = residual;
    bounded_row_ = row;
  }
}

ContactResidual::Worst ContactResidual::worst(FrictionModel model, const Point& point, double ignored) {
  find_largest(model, point);
  for (Quad& largest : largest_) {
    if (largest <= ignored) largest = 0;
  }
  Worst worst;
  measure_errors(point);
  bool fails = false;  // whatever the errors are
  for (std::size_t island = 0; island < largest_.size(); ++island) {
    const Quad scale = scales(model)[island], relative = quotient(largest_[island], scale);
    const Quad error = errors_.empty() ? Quad{0} : errors_[island] / scale;
    const bool decides_itself = abs(relative - kSolvedVelocityResidual) > error || error == 0;
    worst.is_resolved = worst.is_resolved && error <= kResolvedError && decides_itself;
    fails = fails || relative - error > kSolvedVelocityResidual;
    if (largest_[island] == 0) continue;
    worst.residual = larger(worst.residual, largest_[island]);
    if (!(relative > worst.relative)) continue;
    worst.relative = relative;
    worst.row = row_of_[island];
    worst.of_row = largest_[island];
    worst.scale = scale;
  }
  worst.is_resolved = worst.is_resolved || fails;
  worst.of_contacts = problem.has_rows() ? of_contacts_ : worst.residual;
  worst.bounded_row = bounded_row_;
  return worst;
}

/// errors_: how far the residual of each island may be off where the inertia has reduced rank; else empty. That of a
/// round cone or of the convex model adds up those of its three rows, each by the M of another.
void ContactResidual::measure_errors(const Point& point) {
  const QuadVector off = lcp->response_error(point.z);
  errors_.assign(off.empty() ? 0 : rows_.count(), 0);
  for (std::size_t island = 0; island < errors_.size(); ++island) {
    for (const std::size_t row : rows_.rows(island)) {
      errors_[island] = larger_or_infinity(errors_[island], lcp->residual_error(row, point.z, point.w[row], off));
    }
    if (cone) errors_[island] *= 4;
  }
}

double ContactResidual::rho(const Point& point, FrictionModel model, double ignored) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  if (!point.is_finite()) return kUnknown;
  const Worst worst = this->worst(model, point, ignored);
  return worst.is_resolved ? to_double(worst.relative) : kUnknown;
}

}  // namespace lcpbench
