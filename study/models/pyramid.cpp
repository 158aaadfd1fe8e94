#include "study/models/pyramid.h"

#include <cmath>
#include <numbers>

#include "core/round_cone.h"
#include "core/selection.h"

namespace lcpbench {
namespace {

double direction(double angle, int k, int edges) {
  return angle + 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(edges);
}

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

ContactProblem with_pyramid(const ContactProblem& tangents, int edges, const std::vector<double>& angles) {
  ContactProblem result = tangents;
  std::vector<ColumnSum> sums;
  Index begin = 0;
  for (std::size_t c = 0; c < tangents.edges.size(); ++c) {
    if (tangents.edges[c] == 0) continue;
    for (const double sign : {1.0, -1.0}) {  // opposite directions are exactly so
      for (int k = 0; k < edges / 2; ++k) {
        const double angle = direction(angles[c], k, edges);
        sums.push_back({begin, begin + 1, sign * std::cos(angle), sign * std::sin(angle)});
      }
    }
    begin += 4;
    result.edges[c] = edges;
    const auto contact = static_cast<Index>(c), at = 2 * contact;
    if (edges == 0) {
      result.mu(contact) = 0;
      if (result.compliance_t.size() > 0) result.compliance_t(contact) = 0;
      if (result.offset_t.size() > 0) result.offset_t.segment<2>(at).setZero();
    } else if (tangents.offset_t.size() > 0) {  // along the turned tangents
      const double cosine = std::cos(angles[c]), sine = std::sin(angles[c]);
      result.offset_t(at) = cosine * tangents.offset_t(at) + sine * tangents.offset_t(at + 1);
      result.offset_t(at + 1) = cosine * tangents.offset_t(at + 1) - sine * tangents.offset_t(at);
    }
  }
  result.D = combined(tangents.D, sums);
  return result;
}

TangentImpulses tangent_impulses(const ContactProblem& tangents, int edges, const std::vector<double>& angles,
                                 const Vector& z) {
  const Index nc = tangents.nc();
  TangentImpulses impulses{z.head(nc), Vector::Zero(nc), Vector::Zero(nc)};
  Index at = nc;
  for (Index c = 0; c < nc && edges > 0; ++c) {
    const auto contact = static_cast<std::size_t>(c);
    if (tangents.edges[contact] == 0) continue;
    for (int k = 0; k < edges / 2; ++k) {
      const double impulse = z(at + k) - z(at + k + edges / 2);
      impulses.first(c) += impulse * std::cos(direction(angles[contact], k, edges));
      impulses.second(c) += impulse * std::sin(direction(angles[contact], k, edges));
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

std::vector<double> slip_angles(const ContactProblem& tangents, const TangentImpulses& impulses,
                                const Vector& velocity) {
  constexpr double kSlips = 1e-12;  // of the largest term of a slip: less is rounding
  const Index nc = tangents.nc();
  Matrix slips = Matrix::Zero(nc, 2);
  double largest = 0;
  Index begin = 0;
  for (Index c = 0; c < nc; ++c) {
    if (tangents.edges[static_cast<std::size_t>(c)] == 0) continue;
    for (const int tangent : {0, 1}) {
      const double impulse = tangent == 0 ? impulses.first(c) : impulses.second(c);
      const Eigen::Vector3d terms(dot_column(tangents.D, begin + tangent, velocity),
                                  tangents.tangential_offset(c, tangent), tangents.tangential_compliance(c) * impulse);
      slips(c, tangent) = terms.sum();
      largest = std::max(largest, terms.cwiseAbs().maxCoeff());
    }
    begin += 4;
  }
  std::vector<double> angles(static_cast<std::size_t>(nc), 0.0);
  for (Index c = 0; c < nc; ++c) {
    const bool slides = slips.row(c).norm() > kSlips * largest;
    angles[static_cast<std::size_t>(c)] =
        slides ? std::atan2(-slips(c, 1), -slips(c, 0)) : std::atan2(impulses.second(c), impulses.first(c));
  }
  return angles;
}

}  // namespace lcpbench
