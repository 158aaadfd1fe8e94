#include "study/view/contact_numbers.h"

#include "core/compliance.h"
#include "study/evaluation/contact_evaluation.h"
#include "study/evaluation/measures.h"

namespace lcpbench {
namespace {

using Eigen::Vector3d;

/// The sum of the directions of each contact, each times its entry, beside a part along the normal.
/// @param normals  nc @param of_directions  one entry for each of D
std::vector<Vector3d> along_axes(const ContactProblem& problem, const Vector& normals, const Vector& of_directions) {
  std::vector<Vector3d> sums;
  Index direction = 0;
  for (const int edges : problem.edges) {
    Vector3d& sum = sums.emplace_back(normals(std::ssize(sums)), 0, 0);
    for (Index k = 0; k < edges; ++k) {
      const auto [first, second] = edge_direction(k, edges);
      sum += of_directions(direction++) * Vector3d(0, first, second);
    }
  }
  return sums;
}

}  // namespace

std::vector<Vector3d> contact_velocities(const ContactProblem& problem, const Vector& u) {
  const auto projected = [&](const Jacobian& J) {
    Vector speeds(cols(J));
    for (Index j = 0; j < speeds.size(); ++j) speeds(j) = dot_column(J, j, u);
    return speeds;
  };
  std::vector<Vector3d> velocities = along_axes(problem, projected(problem.N), projected(problem.D));
  for (std::size_t c = 0; c < velocities.size(); ++c) {
    // The directions C_k of a regular polygon have sum C_k C_k' = edges / 2 in the plane; two have twice that on a
    // line.
    const double edges = problem.edges[c];
    velocities[c].tail<2>() *= edges > 2 ? 2 / edges : 0.5;
  }
  return velocities;
}

std::vector<Vector3d> contact_impulses(const ContactProblem& problem, const Vector& z) {
  return along_axes(problem, z.head(problem.nc()), z.segment(problem.nc(), cols(problem.D)));
}

std::vector<double> contact_residuals(const ContactProblem& problem, const Vector& z, FrictionModel model) {
  const IslandRows islands(row_islands(problem));
  ContactEvaluation evaluation(problem, islands);
  const QuadVector point = numbers(z);
  if (!evaluation.lcp) return std::vector<double>(problem.edges.size(), Errors::kNone);
  const QuadVector u = evaluation.lcp->response(point), w = evaluation.lcp->all_rows(point, u);
  if (!all_finite(w)) return std::vector<double>(problem.edges.size(), Errors::kNone);
  const ConeFriction friction(problem, *evaluation.lcp);
  const ContactLayout& layout = evaluation.lcp->layout();
  std::vector<double> residuals;
  for (Index contact = 0; contact < problem.nc(); ++contact) {
    const auto c = static_cast<std::size_t>(contact);
    Quad worst = 0;
    const auto take_row = [&](Index row) {
      worst = larger(worst, evaluation.row_residual(static_cast<std::size_t>(row), point, w));
    };
    const bool slides = friction.has_friction(contact);
    if (slides && model == FrictionModel::kConvex) {
      worst = friction.convex_residual(contact, point, u);
    } else {
      take_row(contact);
    }
    if (slides && model == FrictionModel::kCone) worst = larger(worst, friction.residual(contact, point, u));
    if (slides && model == FrictionModel::kPyramid) {
      for (Index j = layout.friction_begin[c]; j < layout.friction_begin[c + 1]; ++j) {
        take_row(layout.friction_offset() + j);
      }
      take_row(layout.lambda_offset() + layout.lambda[c]);
    }
    residuals.push_back(to_double(worst));
  }
  return residuals;
}

}  // namespace lcpbench
