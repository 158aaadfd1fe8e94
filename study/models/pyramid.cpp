#include "study/models/pyramid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/compliance.h"
#include "core/round_cone.h"

namespace lcpbench {
namespace {

double direction(double angle, int k, int edges) {
  return angle + 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(edges);
}

/// `J` with the columns of `sums`, each a J_first + b J_second.
struct ColumnSum {
  Index first = 0, second = 0;
  double a = 0, b = 0;
};

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

/// The rows of J at `indices`.
Jacobian rows_of(const Jacobian& J, const std::vector<Index>& indices) {
  const auto* dense = std::get_if<Matrix>(&J);
  if (dense != nullptr) return Matrix((*dense)(indices, Eigen::all));
  SparseMatrix select(static_cast<Index>(indices.size()), rows(J));
  for (std::size_t i = 0; i < indices.size(); ++i) select.insert(static_cast<Index>(i), indices[i]) = 1;
  return SparseMatrix(select * std::get<SparseMatrix>(J));
}

/// Of an island's coordinates, ascending. The part of a body that no contact of the island moves may be missing.
Inertia inertia_of(const Inertia& inertia, const std::vector<Index>& coordinates) {
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) return DenseInertia{dense->G(coordinates, coordinates)};
  if (const auto* inverse = std::get_if<InverseInertia>(&inertia)) {
    return InverseInertia{inverse->Ginv(coordinates, coordinates)};
  }
  if (const auto* bodies = std::get_if<BlockInertia>(&inertia)) {
    BlockInertia part;
    Index begin = 0;
    auto at = coordinates.begin();
    for (const Matrix& block : bodies->blocks) {
      std::vector<Index> inside;
      for (; at != coordinates.end() && *at < begin + block.rows(); ++at) inside.push_back(*at - begin);
      if (!inside.empty()) part.blocks.push_back(block(inside, inside));
      begin += block.rows();
    }
    return part;
  }
  const auto& factors = std::get<FactoredInertia>(inertia);
  const Matrix X = factors.X(coordinates, Eigen::all);
  std::vector<Index> used;
  for (Index k = 0; k < X.cols(); ++k) {
    if (!X.col(k).isZero(0)) used.push_back(k);
  }
  return FactoredInertia{X(Eigen::all, used), factors.alpha(used)};
}

double dot(const Jacobian& J, Index column, const Vector& v) {
  return std::visit([&](const auto& matrix) { return matrix.col(column).dot(v); }, J);
}

}  // namespace

ContactProblem with_tangents(const ContactProblem& problem) {
  std::vector<ColumnSum> sums;
  ContactProblem result = problem;
  Index begin = 0;
  for (std::size_t c = 0; c < problem.edges.size(); ++c) {
    const int edges = problem.edges[c];
    if (edges > 0) {
      for (const double sign : {1.0, -1.0}) {
        for (const Index tangent : {begin, begin + edges / 4}) sums.push_back({tangent, 0, sign, 0});
      }
      result.edges[c] = 4;
    }
    begin += edges;
  }
  result.D = combined(problem.D, sums);
  return result;
}

ContactProblem island_problem(const ContactProblem& tangents, const Island& island) {
  const ContactLayout layout = contact_layout(tangents);
  ContactProblem part;
  std::vector<ColumnSum> normals;
  std::vector<ColumnSum> directions;
  for (const Index contact : island.contacts) {
    const auto c = static_cast<std::size_t>(contact);
    normals.push_back({contact, 0, 1, 0});
    for (Index j = layout.friction_begin[c]; j < layout.friction_begin[c + 1]; ++j) directions.push_back({j, 0, 1, 0});
    part.edges.push_back(tangents.edges[c]);
  }
  part.v = tangents.v(island.coordinates);
  part.mu = tangents.mu(island.contacts);
  if (tangents.has_offset()) part.b = tangents.b(island.contacts);
  select_softness(tangents, island.contacts, part);
  part.N = rows_of(combined(tangents.N, normals), island.coordinates);
  part.D = rows_of(combined(tangents.D, directions), island.coordinates);
  part.inertia = inertia_of(tangents.inertia, island.coordinates);
  return part;
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
    if (tangents.offset_t.size() > 0) {  // along the turned tangents
      const auto at = static_cast<Index>(2 * c);
      const double cosine = std::cos(angles[c]), sine = std::sin(angles[c]);
      result.offset_t(at) = cosine * tangents.offset_t(at) + sine * tangents.offset_t(at + 1);
      result.offset_t(at + 1) = cosine * tangents.offset_t(at + 1) - sine * tangents.offset_t(at);
    }
    if (edges == 0) result.mu(static_cast<Index>(c)) = 0;
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
  constexpr double kSlips = 1e-12;  // of the largest slip: less is rounding
  const Index nc = tangents.nc();
  Matrix slips = Matrix::Zero(nc, 2);
  Index begin = 0;
  for (Index c = 0; c < nc; ++c) {
    if (tangents.edges[static_cast<std::size_t>(c)] == 0) continue;
    slips.row(c) << dot(tangents.D, begin, velocity), dot(tangents.D, begin + 1, velocity);
    begin += 4;
  }
  const double largest = nc > 0 ? slips.cwiseAbs().maxCoeff() : 0.0;
  std::vector<double> angles(static_cast<std::size_t>(nc), 0.0);
  for (Index c = 0; c < nc; ++c) {
    const bool slides = slips.row(c).norm() > kSlips * largest;
    angles[static_cast<std::size_t>(c)] =
        slides ? std::atan2(-slips(c, 1), -slips(c, 0)) : std::atan2(impulses.second(c), impulses.first(c));
  }
  return angles;
}

}  // namespace lcpbench
