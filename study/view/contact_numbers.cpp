#include "study/view/contact_numbers.h"

#include <algorithm>
#include <cmath>

#include "core/compliance.h"

namespace lcpbench {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

SparseMatrix sparse(const Jacobian& J) {
  const auto* given = std::get_if<SparseMatrix>(&J);
  return given != nullptr ? *given : SparseMatrix(std::get<Matrix>(J).sparseView());
}

/// G*: of separate bodies one block for each.
SparseMatrix response(const Inertia& inertia) {
  const auto* bodies = std::get_if<BlockInertia>(&inertia);
  if (bodies == nullptr) return inverse_inertia(inertia).sparseView();
  std::vector<Eigen::Triplet<double>> entries;
  Index first = 0;
  for (const Matrix& block : bodies->blocks) {
    const Matrix inverse = inverse_inertia(DenseInertia{block});
    for (Index i = 0; i < block.rows(); ++i) {
      for (Index j = 0; j < block.rows(); ++j) entries.emplace_back(first + i, first + j, inverse(i, j));
    }
    first += block.rows();
  }
  SparseMatrix all(first, first);
  all.setFromTriplets(entries.begin(), entries.end());
  return all;
}

/// The nearest point of the cone |x_t| <= mu x_N.
Vector3d in_cone(double mu, const Vector3d& x) {
  const double reach = x.tail<2>().norm();
  if (reach <= mu * x.x()) return x;
  const double height = std::max((x.x() + mu * reach) / (1 + mu * mu), 0.0);
  Vector3d nearest(height, 0, 0);
  if (reach > 0) nearest.tail<2>() = mu * height / reach * x.tail<2>();
  return nearest;
}

/// J_i'G* J_i of every column.
Vector diagonal(const SparseMatrix& J, const SparseMatrix& response) {
  return J.cwiseProduct(SparseMatrix(response * J)).transpose() * Vector::Ones(J.rows());
}

}  // namespace

ContactNumbers::ContactNumbers(const ContactProblem& problem)
    : problem_(problem), layout_(contact_layout(problem)), N_(sparse(problem.N)), D_(sparse(problem.D)) {
  const SparseMatrix inverse = response(problem.inertia);
  normal_mass_ = diagonal(N_, inverse);
  friction_mass_ = diagonal(D_, inverse);
}

std::vector<Vector3d> ContactNumbers::velocities(const Vector& u) const {
  const Vector normal = N_.transpose() * u;
  const Vector slip = D_.transpose() * u;
  std::vector<Vector3d> velocities;
  for (std::size_t c = 0; c < problem_.edges.size(); ++c) {
    // The directions C_k of a regular polygon have sum C_k C_k' = edges / 2 in the plane; two have twice that on a line.
    const double edges = problem_.edges[c];
    velocities.emplace_back(normal(static_cast<Index>(c)), 0, 0);
    velocities.back().tail<2>() = (edges > 2 ? 2 / edges : 0.5) * along_tangents(c, slip);
  }
  return velocities;
}

std::vector<Vector3d> ContactNumbers::impulses(const Vector& z) const {
  const auto friction = z.segment(layout_.nc, layout_.friction_begin.back());
  std::vector<Vector3d> impulses;
  for (std::size_t c = 0; c < problem_.edges.size(); ++c) {
    impulses.emplace_back(z(static_cast<Index>(c)), 0, 0);
    impulses.back().tail<2>() = along_tangents(c, friction);
  }
  return impulses;
}

Vector2d ContactNumbers::along_tangents(std::size_t contact, const Eigen::Ref<const Vector>& of_directions) const {
  Vector2d sum = Vector2d::Zero();
  for (Index k = 0; k < problem_.edges[contact]; ++k) {
    const auto [first, second] = edge_direction(k, problem_.edges[contact]);
    sum += of_directions(layout_.friction_begin[contact] + k) * Vector2d(first, second);
  }
  return sum;
}

std::vector<double> ContactNumbers::residuals(const Vector& z, const Vector& u, FrictionModel model) const {
  const std::vector<Vector3d> f = impulses(z);
  const std::vector<Vector3d> after = velocities(u);
  const Vector slip = D_.transpose() * u;
  std::vector<double> residuals;
  for (Index contact = 0; contact < layout_.nc; ++contact) {
    const auto c = static_cast<std::size_t>(contact);
    const double mu = problem_.mu(contact);
    const double yields = problem_.tangential_compliance(contact);
    const double normal_mass = normal_mass_(contact) + problem_.normal_compliance(contact);
    const double w = after[c].x() + problem_.offset(contact) + problem_.normal_compliance(contact) * z(contact);
    const Vector2d moved = Vector2d(problem_.tangential_offset(contact, 0), problem_.tangential_offset(contact, 1)) +
                           yields * f[c].tail<2>();  // what w has of softness and offsets along the tangents
    const Vector2d w_t = after[c].tail<2>() + moved;
    double worst = std::abs(std::min(normal_mass * z(contact), w));
    const Index first = layout_.friction_begin[c];
    if (problem_.edges[c] > 0 && model != FrictionModel::kPyramid) {
      const double mass = std::max(friction_mass_(first), friction_mass_(first + problem_.edges[c] / 4)) + yields;
      if (model == FrictionModel::kConvex) {
        const double m = std::max(mass, normal_mass);
        const Vector3d aim = m * f[c] - Vector3d(w, w_t.x(), w_t.y());
        worst = (m * f[c] - in_cone(mu, aim)).norm();
      } else {
        const Vector2d aim = mass * f[c].tail<2>() - w_t;
        const double radius = mu * mass * std::max(z(contact), 0.0);
        const double shrink = aim.norm() > radius ? radius / aim.norm() : 1.0;
        worst = std::max(worst, (mass * f[c].tail<2>() - shrink * aim).norm());
      }
    } else if (problem_.edges[c] > 0) {
      const double lambda = z(layout_.lambda_offset() + layout_.lambda[c]);
      double slack = mu * z(contact);
      for (Index k = 0; k < problem_.edges[c]; ++k) {
        const auto [along, across] = edge_direction(k, problem_.edges[c]);
        const double impulse = z(layout_.nc + first + k);
        const double mass = friction_mass_(first + k) + yields * (along * along + across * across);
        slack -= impulse;
        worst = std::max(worst, std::abs(std::min(mass * impulse, slip(first + k) + along * moved.x() +
                                                                      across * moved.y() + lambda)));
      }
      worst = std::max(worst, std::abs(std::min(lambda, normal_mass * slack)));
    }
    residuals.push_back(worst);
  }
  return residuals;
}

}  // namespace lcpbench
