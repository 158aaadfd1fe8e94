#include "study/models/pyramid.h"

#include <cmath>
#include <numbers>

#include "core/round_cone.h"
#include "core/selection.h"

namespace lcpbench {
namespace {

double angle(int k, int edges) { return 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(edges); }

/// The column a J_first + b J_second.
struct ColumnSum {
  Index first = 0, second = 0;
  double a = 0, b = 0;
};

/// A matrix with a column for each of `sums`.
Jacobian combined(const Jacobian& J, const std::vector<ColumnSum>& sums) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const auto column = static_cast<int>(k);
    if (sums[k].a != 0) entries.emplace_back(static_cast<int>(sums[k].first), column, sums[k].a);
    if (sums[k].b != 0) entries.emplace_back(static_cast<int>(sums[k].second), column, sums[k].b);
  }
  SparseMatrix mix(cols(J), static_cast<Index>(sums.size()));
  mix.setFromTriplets(entries.begin(), entries.end());
  if (const auto* sparse = std::get_if<SparseMatrix>(&J)) return SparseMatrix(*sparse * mix);
  return Matrix(std::get<Matrix>(J) * mix);
}

}  // namespace

ContactProblem with_tangents(const ContactProblem& problem) {
  std::vector<Index> directions;
  ContactProblem result = problem;
  Index begin = 0;
  for (int& edges : result.edges) {
    for (int quarter = 0; quarter < 4 && edges > 0; ++quarter) directions.push_back(begin + quarter * edges / 4);
    begin += edges;
    edges = edges > 0 ? 4 : 0;
  }
  result.D = part_of(problem.D, all_indices(problem.ngc()), directions);
  return result;
}

ContactProblem with_pyramid(const ContactProblem& tangents, int edges) {
  ContactProblem result = tangents;
  std::vector<ColumnSum> sums;
  Index begin = 0;
  for (std::size_t c = 0; c < tangents.edges.size(); ++c) {
    if (tangents.edges[c] == 0) continue;
    for (const double sign : {1.0, -1.0}) {  // opposite directions are exactly so
      for (int k = 0; k < edges / 2; ++k) {
        sums.push_back({begin, begin + 1, sign * std::cos(angle(k, edges)), sign * std::sin(angle(k, edges))});
      }
    }
    begin += 4;
    result.edges[c] = edges;
    if (edges > 0) continue;
    const auto contact = static_cast<Index>(c);
    result.mu(contact) = 0;
    if (result.compliance_t.size() > 0) result.compliance_t(contact) = 0;
    if (result.offset_t.size() > 0) result.offset_t.segment<2>(2 * contact).setZero();
  }
  result.D = combined(tangents.D, sums);
  return result;
}

TangentImpulses tangent_impulses(const ContactProblem& tangents, int edges, const Vector& z) {
  const Index nc = tangents.nc();
  TangentImpulses impulses{z.head(nc), Vector::Zero(nc), Vector::Zero(nc)};
  Index at = nc;
  for (Index c = 0; c < nc && edges > 0; ++c) {
    if (tangents.edges[static_cast<std::size_t>(c)] == 0) continue;
    for (int k = 0; k < edges / 2; ++k) {
      const double impulse = z(at + k) - z(at + k + edges / 2);
      impulses.first(c) += impulse * std::cos(angle(k, edges));
      impulses.second(c) += impulse * std::sin(angle(k, edges));
    }
    at += edges;
  }
  return impulses;
}

Vector pyramid_impulses(const ContactProblem& tangents, const TangentImpulses& impulses) {
  const ContactLayout layout = contact_layout(tangents);
  Vector z = Vector::Zero(layout.size());
  z.head(layout.nc) = impulses.normal;
  for (Index c = 0; c < layout.nc; ++c) {
    if (layout.lambda[static_cast<std::size_t>(c)] < 0) continue;
    const Index begin = layout.friction_offset() + layout.friction_begin[static_cast<std::size_t>(c)];
    share_among_directions(impulses.first(c), impulses.second(c), z.segment(begin, 4));
  }
  complete_slip_bounds(tangents, layout, post_impact_velocity(tangents, z), z);
  return z;
}

}  // namespace lcpbench
