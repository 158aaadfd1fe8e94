#include "study/view/contact_numbers.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lcpbench {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double along(const Jacobian& J, Index of, const Vector& u) {
  return std::visit([&](const auto& matrix) { return matrix.col(of).dot(u); }, J);
}

/// M_ii of a column of the Jacobian.
double diagonal(const Jacobian& J, Index of, const Matrix& inverse) {
  const Vector column = std::visit([&](const auto& matrix) { return Vector(matrix.col(of)); }, J);
  return column.dot(inverse * column);
}

/// The friction impulse along the two tangents.
Vector2d friction_impulse(const Vector& z, Index first, int edges) {
  Vector2d sum = Vector2d::Zero();
  for (int k = 0; k < edges; ++k) {
    const double angle = 2 * std::numbers::pi * k / edges;
    sum += z(first + k) * Vector2d(std::cos(angle), std::sin(angle));
  }
  return sum;
}

/// The largest residual of the contact's rows that are about the pyramid.
double pyramid_residual(const ContactProblem& problem, const Matrix& inverse, const ContactLayout& layout,
                        const Vector& z, const Vector& u, Index contact) {
  const auto c = static_cast<std::size_t>(contact);
  const Index lambda = layout.lambda_offset() + layout.lambda[c];
  const double normal_mass = diagonal(problem.N, contact, inverse);
  double slack = problem.mu(contact) * z(contact);
  double largest = 0;
  for (Index k = layout.friction_begin[c]; k < layout.friction_begin[c + 1]; ++k) {
    const double f = z(layout.friction_offset() + k);
    slack -= f;
    const double w = along(problem.D, k, u) + z(lambda);
    largest = std::max(largest, std::abs(std::min(diagonal(problem.D, k, inverse) * f, w)));
  }
  return std::max(largest, std::abs(std::min(z(lambda), normal_mass * slack)));
}

/// The residual of the round cone: see measure_cone().
double cone_residual(const ContactProblem& problem, const Matrix& inverse, const ContactLayout& layout,
                     double normal_impulse, const Vector2d& friction, const Vector3d& velocity, Index contact) {
  const auto c = static_cast<std::size_t>(contact);
  const Index first = layout.friction_begin[c];
  const double mass = std::max(diagonal(problem.D, first, inverse),
                               diagonal(problem.D, first + problem.edges[c] / 4, inverse));
  const Vector2d held = mass * friction;
  const Vector2d aim = held - velocity.tail<2>();
  const double radius = problem.mu(contact) * mass * std::max(normal_impulse, 0.0);
  return (held - (aim.norm() > radius ? radius / aim.norm() : 1.0) * aim).norm();
}

}  // namespace

std::vector<Vector3d> contact_velocities(const ContactProblem& problem, const Vector& u) {
  const ContactLayout layout = contact_layout(problem);
  std::vector<Vector3d> velocities;
  for (std::size_t c = 0; c < problem.edges.size(); ++c) {
    const int edges = problem.edges[c];
    const Index first = layout.friction_begin[c];
    velocities.emplace_back(along(problem.N, static_cast<Index>(c), u), edges > 0 ? along(problem.D, first, u) : 0.0,
                            edges > 0 && edges % 4 == 0 ? along(problem.D, first + edges / 4, u) : 0.0);
  }
  return velocities;
}

ContactNumbers contact_numbers(const ContactProblem& problem, const Matrix& inverse, const Vector& z,
                               FrictionModel model) {
  const ContactLayout layout = contact_layout(problem);
  ContactNumbers numbers;
  numbers.velocity = post_impact_velocity(problem, z);
  numbers.velocities = contact_velocities(problem, numbers.velocity);
  for (Index contact = 0; contact < problem.nc(); ++contact) {
    const auto c = static_cast<std::size_t>(contact);
    const Vector2d friction =
        friction_impulse(z, layout.friction_offset() + layout.friction_begin[c], problem.edges[c]);
    numbers.impulses.emplace_back(z(contact), friction.x(), friction.y());
    const double w = numbers.velocities[c].x() + problem.offset(contact);
    double residual = std::abs(std::min(diagonal(problem.N, contact, inverse) * z(contact), w));
    if (problem.edges[c] > 0) {
      const bool cone = model == FrictionModel::kCone;
      residual = std::max(residual, cone ? cone_residual(problem, inverse, layout, z(contact), friction,
                                                         numbers.velocities[c], contact)
                                         : pyramid_residual(problem, inverse, layout, z, numbers.velocity, contact));
    }
    numbers.residuals.push_back(residual);
  }
  return numbers;
}

}  // namespace lcpbench
