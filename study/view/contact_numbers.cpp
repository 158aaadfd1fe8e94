#include "study/view/contact_numbers.h"

#include <algorithm>
#include <cmath>
#include <numbers>

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

/// M_ii of every column.
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
    const int edges = problem_.edges[c];
    const Index first = layout_.friction_begin[c];
    velocities.emplace_back(normal(static_cast<Index>(c)), edges > 0 ? slip(first) : 0.0,
                            edges > 0 && edges % 4 == 0 ? slip(first + edges / 4) : 0.0);
  }
  return velocities;
}

std::vector<Vector3d> ContactNumbers::impulses(const Vector& z) const {
  std::vector<Vector3d> impulses;
  for (std::size_t c = 0; c < problem_.edges.size(); ++c) {
    Vector3d sum(z(static_cast<Index>(c)), 0, 0);
    for (int k = 0; k < problem_.edges[c]; ++k) {
      const double angle = 2 * std::numbers::pi * k / problem_.edges[c];
      sum.tail<2>() += z(layout_.nc + layout_.friction_begin[c] + k) * Vector2d(std::cos(angle), std::sin(angle));
    }
    impulses.push_back(sum);
  }
  return impulses;
}

std::vector<double> ContactNumbers::residuals(const Vector& z, const Vector& u, FrictionModel model) const {
  const std::vector<Vector3d> f = impulses(z);
  const std::vector<Vector3d> after = velocities(u);
  const Vector slip = D_.transpose() * u;
  std::vector<double> residuals;
  for (Index contact = 0; contact < layout_.nc; ++contact) {
    const auto c = static_cast<std::size_t>(contact);
    const double normal_mass = normal_mass_(contact);
    double worst = std::abs(std::min(normal_mass * z(contact), after[c].x() + problem_.offset(contact)));
    const Index first = layout_.friction_begin[c];
    if (problem_.edges[c] > 0 && model == FrictionModel::kCone) {
      const double mass = std::max(friction_mass_(first), friction_mass_(first + problem_.edges[c] / 4));
      const Vector2d held = mass * f[c].tail<2>();
      const Vector2d aim = held - after[c].tail<2>();
      const double radius = problem_.mu(contact) * mass * std::max(z(contact), 0.0);
      worst = std::max(worst, (held - (aim.norm() > radius ? radius / aim.norm() : 1.0) * aim).norm());
    } else if (problem_.edges[c] > 0) {
      const double lambda = z(layout_.lambda_offset() + layout_.lambda[c]);
      double slack = problem_.mu(contact) * z(contact);
      for (Index k = first; k < layout_.friction_begin[c + 1]; ++k) {
        const double impulse = z(layout_.nc + k);
        slack -= impulse;
        worst = std::max(worst, std::abs(std::min(friction_mass_(k) * impulse, slip(k) + lambda)));
      }
      worst = std::max(worst, std::abs(std::min(lambda, normal_mass * slack)));
    }
    residuals.push_back(worst);
  }
  return residuals;
}

}  // namespace lcpbench
