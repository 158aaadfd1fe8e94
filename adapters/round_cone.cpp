#include "adapters/round_cone.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/round_cone.h"

namespace lcpbench {

bool RoundCones::has_tangents(Index contact) const {
  return !layout_.lambda.empty() && layout_.lambda[static_cast<std::size_t>(contact)] >= 0;
}

std::string RoundCones::load(const Problem& problem, Frictionless frictionless) {
  const ContactProblem* contact = problem.contact();
  layout_ = contact != nullptr ? contact_layout(*contact) : ContactLayout{.nc = problem.size()};
  if (contact == nullptr && problem.lcp().M != problem.lcp().M.transpose()) {
    return "needs a symmetric M, or the contacts that M came from";
  }
  if (frictional()) {
    if (std::string why = why_no_round_cone(*contact); !why.empty()) return why;
  }
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<Index> unconnected;
  mu_.assign(static_cast<std::size_t>(layout_.nc), 0.0);
  normal_row_.clear();
  Index m = 0;
  for (Index i = 0; i < layout_.nc; ++i) {
    normal_row_.push_back(m);
    entries.emplace_back(i, m++, 1.0);
    if (has_tangents(i)) {
      mu_[static_cast<std::size_t>(i)] = contact->mu(i);
      const auto [begin, edges] = directions(i);
      entries.emplace_back(begin, m++, 1.0);
      entries.emplace_back(begin + edges / 4, m++, 1.0);
    } else if (frictionless == Frictionless::kThreeRows) {
      unconnected.insert(unconnected.end(), {m, m + 1});
      m += 2;
    }
  }
  lcp_ = finite_lcp(problem);
  SparseMatrix rows(lcp_.size(), m);
  rows.setFromTriplets(entries.begin(), entries.end());
  W_ = rows.transpose() * (lcp_.M * rows).eval();
  q_ = rows.transpose() * lcp_.q;
  for (const Index row : unconnected) W_(row, row) = 1;
  return {};
}

Vector RoundCones::read(const Vector& z) const {
  Vector r = Vector::Zero(q_.size());
  for (Index i = 0; i < layout_.nc; ++i) {
    r(normal_row(i)) = z(i);
    if (!has_tangents(i)) continue;
    const auto [begin, edges] = directions(i);
    for (Index k = 0; k < edges; ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(edges);
      r(normal_row(i) + 1) += std::cos(angle) * z(begin + k);
      r(normal_row(i) + 2) += std::sin(angle) * z(begin + k);
    }
  }
  return r;
}

void RoundCones::write(const Vector& r, Vector& z) const {
  z.setZero(lcp_.size());
  for (Index i = 0; i < layout_.nc; ++i) {
    const Index row = normal_row(i);
    z(i) = r(row);
    if (!has_tangents(i)) continue;
    const auto [begin, edges] = directions(i);
    share_among_directions(r(row + 1), r(row + 2), z.segment(begin, edges));
  }
  if (frictional()) complete_slip_bounds(lcp_, layout_, z);
}

void complete_slip_bounds(const Lcp& lcp, const ContactLayout& layout, Vector& z) {
  const Vector w = lcp.M * z + lcp.q;  // lambda is still zero: its rows are slips
  for (const Index contact : layout.cone_contact) {
    const auto i = static_cast<std::size_t>(contact);
    const auto slips = w.segment(layout.friction_offset() + layout.friction_begin[i],
                                 layout.friction_begin[i + 1] - layout.friction_begin[i]);
    z(layout.lambda_offset() + layout.lambda[i]) = std::max(-slips.minCoeff(), 0.0);
  }
}

}  // namespace lcpbench
