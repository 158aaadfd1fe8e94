#include "core/round_cone.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/compliance.h"

namespace lcpbench {
namespace {

double angle(Index direction, Index edges) {
  return 2 * std::numbers::pi * static_cast<double>(direction) / static_cast<double>(edges);
}

constexpr double kTolerance = 1e-12;

/// Why the columns from `begin` on are not cos(2 pi k / edges) t1 + sin(2 pi k / edges) t2 with two tangents, or "".
template <class Matrix>
std::string why_no_polygon(const Matrix& D, Index begin, Index edges) {
  const auto t1 = D.col(begin), t2 = D.col(begin + edges / 4);
  const double size = std::max(t1.norm(), t2.norm());
  if (size > 0 && std::min((t1 - t2).norm(), (t1 + t2).norm()) <= kTolerance * size) {
    return "two tangents that are the same direction";
  }
  for (Index k = 0; edges > 4 && k < edges / 2; ++k) {
    const double c = std::cos(angle(k, edges)), s = std::sin(angle(k, edges));
    if (!((D.col(begin + k) - (c * t1 + s * t2)).norm() <= kTolerance * size)) {
      return "friction directions that are no regular polygon";
    }
  }
  return {};
}

}  // namespace

std::string why_no_round_cone(const ContactProblem& problem) {
  Index begin = 0;
  for (const int edges : problem.edges) {
    if (edges % 4 != 0) return "a contact of " + std::to_string(edges) + " edges: takes multiples of 4";
    if (edges > 0) {
      const auto of = [&](const auto& D) { return why_no_polygon(D, begin, edges); };
      if (std::string why = std::visit(of, problem.D); !why.empty()) return why;
    }
    begin += edges;
  }
  return {};
}

void share_among_directions(double a, double b, Eigen::Ref<Vector> f) {
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

void complete_slip_bounds(const ContactProblem& problem, const ContactLayout& layout, const Vector& u, Vector& z) {
  const SoftRows<double> soft(problem, layout);
  for (Index cone = 0; cone < layout.cones; ++cone) {
    const Index contact = layout.cone_contact[static_cast<std::size_t>(cone)];
    const Index begin = layout.friction_begin[static_cast<std::size_t>(contact)];
    const auto yielding = soft.yielding(contact, [&](Index j) { return z(j); });
    double bound = 0;
    for (Index k = 0; k < problem.edges[static_cast<std::size_t>(contact)]; ++k) {
      double slip = dot_column(problem.D, begin + k, u);
      if (problem.is_soft()) slip += soft.along(contact, k, soft.offset(contact)) + soft.along(contact, k, yielding);
      bound = std::max(bound, -slip);
    }
    z(layout.lambda_offset() + cone) = bound;
  }
}

}  // namespace lcpbench
