#include "adapters/round_cone.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/solver.h"

namespace lcpbench {
namespace {

double angle(Index direction, Index edges) {
  return 2 * std::numbers::pi * static_cast<double>(direction) / static_cast<double>(edges);
}

/// Whether the columns from `begin` on are cos(2 pi k / edges) t1 + sin(2 pi k / edges) t2.
bool is_regular_polygon(const Matrix& D, Index begin, Index edges) {
  constexpr double kTolerance = 1e-6;  // as that of a scene's normals and tangents
  const Vector t1 = D.col(begin);
  const Vector t2 = D.col(begin + edges / 4);
  const double size = std::max(t1.lpNorm<Eigen::Infinity>(), t2.lpNorm<Eigen::Infinity>());
  for (Index k = 0; k < edges / 2; ++k) {
    const Vector expected = std::cos(angle(k, edges)) * t1 + std::sin(angle(k, edges)) * t2;
    if (!((D.col(begin + k) - expected).lpNorm<Eigen::Infinity>() <= kTolerance * size)) return false;
  }
  return true;
}

/// Shares the impulse (a, b) among the two of the directions that it lies between.
void share(double a, double b, Eigen::Ref<Vector> f) {
  const Index edges = f.size();
  f.setZero();
  if (edges == 4) {
    f << std::max(a, 0.0), std::max(b, 0.0), std::max(-a, 0.0), std::max(-b, 0.0);
    return;
  }
  if (!std::isfinite(a) || !std::isfinite(b)) {
    f(0) = a + b;
    return;
  }
  const double step = angle(1, edges);
  double theta = std::atan2(b, a);
  if (theta < 0) theta += 2 * std::numbers::pi;
  const Index k = std::min(static_cast<Index>(theta / step), edges - 1);
  const double past = theta - angle(k, edges);
  f(k) = std::hypot(a, b) * std::max(std::sin(step - past), 0.0) / std::sin(step);
  f((k + 1) % edges) = std::hypot(a, b) * std::max(std::sin(past), 0.0) / std::sin(step);
}

}  // namespace

bool RoundCones::has_tangents(Index contact) const {
  return !layout_.lambda.empty() && layout_.lambda[static_cast<std::size_t>(contact)] >= 0;
}

std::string RoundCones::load(const Problem& problem, bool take_friction, Frictionless frictionless) {
  const ContactProblem* contact = problem.contact();
  layout_ = contact != nullptr ? contact_layout(*contact) : ContactLayout{.nc = problem.size()};
  if (contact == nullptr && problem.lcp().M != problem.lcp().M.transpose()) {
    return "needs a symmetric M, or the contacts that M came from";
  }
  if (frictional() && !take_friction) {
    return "has a round friction cone, which is another problem than this pyramid: cone=true solves that one";
  }
  const Matrix D = contact != nullptr ? to_dense(contact->D) : Matrix();
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
      if (std::string why = add_tangents(*contact, D, i, entries, m); !why.empty()) return why;
      m += 2;
    } else if (frictionless == Frictionless::kThreeRows) {
      unconnected.insert(unconnected.end(), {m, m + 1});
      m += 2;
    }
  }
  lcp_ = make_lcp(problem);
  SparseMatrix rows(lcp_.size(), m);
  rows.setFromTriplets(entries.begin(), entries.end());
  W_ = rows.transpose() * (lcp_.M * rows).eval();
  q_ = rows.transpose() * lcp_.q;
  for (const Index row : unconnected) W_(row, row) = 1;
  return {};
}

std::string RoundCones::add_tangents(const ContactProblem& contact, const Matrix& D, Index i,
                                     std::vector<Eigen::Triplet<double>>& entries, Index row) const {
  const Index edges = contact.edges[static_cast<std::size_t>(i)];
  const Index begin = layout_.friction_begin[static_cast<std::size_t>(i)];
  if (edges % 4 != 0) return "a contact of " + std::to_string(edges) + " edges: takes multiples of 4";
  if (edges > 4 && !is_regular_polygon(D, begin, edges)) return "friction directions that are no regular polygon";
  entries.emplace_back(layout_.friction_offset() + begin, row, 1.0);
  entries.emplace_back(layout_.friction_offset() + begin + edges / 4, row + 1, 1.0);
  return {};
}

void RoundCones::write(const Vector& r, Vector& z) const {
  z.setZero(lcp_.size());
  for (Index i = 0; i < layout_.nc; ++i) {
    const Index row = normal_row(i);
    z(i) = r(row);
    if (!has_tangents(i)) continue;
    const Index begin = layout_.friction_begin[static_cast<std::size_t>(i)];
    const Index edges = layout_.friction_begin[static_cast<std::size_t>(i) + 1] - begin;
    share(r(row + 1), r(row + 2), z.segment(layout_.friction_offset() + begin, edges));
  }
  if (!frictional()) return;
  const Vector w = lcp_.M * z + lcp_.q;  // lambda is still zero: its rows are slips
  for (const Index i : layout_.cone_contact) {
    const Index begin = layout_.friction_begin[static_cast<std::size_t>(i)];
    const Index edges = layout_.friction_begin[static_cast<std::size_t>(i) + 1] - begin;
    const double slip = -w.segment(layout_.friction_offset() + begin, edges).minCoeff();
    z(layout_.lambda_offset() + layout_.lambda[static_cast<std::size_t>(i)]) = std::max(slip, 0.0);
  }
}

}  // namespace lcpbench
