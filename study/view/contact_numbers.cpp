#include "study/view/contact_numbers.h"

#include <algorithm>

#include "core/answer/contact_residual.h"
#include "core/compliance.h"

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
  std::vector<double> none(problem.edges.size(), Errors::kNone);
  ContactResidual contacts(problem);
  if (!contacts.lcp || (model != FrictionModel::kPyramid && problem.frictional() && !contacts.cone)) return none;
  const ContactResidual::Point point = contacts.at(z);
  if (!point.is_finite()) return none;
  std::vector<double> residuals(problem.edges.size(), 0);
  contacts.for_each_row(model, point, [&](Index row, Quad residual) {
    if (contacts.lcp->is_bounded(static_cast<std::size_t>(row))) return;
    double& worst = residuals[static_cast<std::size_t>(contacts.lcp->contact_of(row))];
    worst = std::max(worst, to_double(residual));
  });
  return residuals;
}

}  // namespace lcpbench
