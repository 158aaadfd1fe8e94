#include "native/steppers/delassus.h"

namespace lcpbench::steppers {

Delassus delassus(const World& world, double h) {
  const auto rows = static_cast<Index>(3 * world.contacts.size());
  const auto columns = static_cast<Index>(6 * world.bodies.size());
  std::vector<Eigen::Triplet<double>> jacobian;
  std::vector<Eigen::Triplet<double>> inverse;
  Delassus result;
  result.g.resize(rows);
  for (std::size_t i = 0; i < world.contacts.size(); ++i) {
    const StepContact& contact = world.contacts[i];
    const auto row = static_cast<Index>(3 * i);
    result.g.segment<3>(row) = world.relative_velocity(contact);
    result.g(row) += velocity_bias(contact, h, 0);
    for (const double sign : {1.0, -1.0}) {
      const auto at = static_cast<Index>(6 * (sign > 0 ? contact.a : contact.b));
      for (Index k = 0; k < 3; ++k) {
        const Vector3d direction = sign * contact.frame.row(k);
        const Vector3d moment = (sign > 0 ? contact.arm_a : contact.arm_b).cross(direction);
        for (Index j = 0; j < 3; ++j) {
          jacobian.emplace_back(row + k, at + j, direction(j));
          jacobian.emplace_back(row + k, at + 3 + j, moment(j));
        }
      }
    }
  }
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    const MovingBody& body = world.bodies[i];
    const auto at = static_cast<Index>(6 * i);
    for (Index j = 0; j < 3; ++j) {
      inverse.emplace_back(at + j, at + j, body.inverse_mass);
      for (Index k = 0; k < 3; ++k) inverse.emplace_back(at + 3 + j, at + 3 + k, body.inverse_inertia(j, k));
    }
  }
  SparseMatrix J(rows, columns);
  SparseMatrix M(columns, columns);
  J.setFromTriplets(jacobian.begin(), jacobian.end());
  M.setFromTriplets(inverse.begin(), inverse.end());
  const SparseMatrix half = J * M;
  result.W = half * SparseMatrix(J.transpose());
  return result;
}

void project_on_cones(const World& world, Vector& f) {
  for (std::size_t i = 0; i < world.contacts.size(); ++i) {
    const double mu = world.contacts[i].mu;
    const auto at = static_cast<Index>(3 * i);
    const double normal = f(at);
    const double tangent = f.segment<2>(at + 1).norm();
    if (normal >= 0 && tangent <= mu * normal) continue;
    const double nearest = std::max(0.0, (normal + mu * tangent) / (1 + mu * mu));
    f(at) = nearest;
    f.segment<2>(at + 1) *= tangent > 0 ? mu * nearest / tangent : 0;
  }
}

void ConeStepper::run(World& world, double h) {
  world.push(1);
  if (!settings_.warm) world.clear_impulses();
  if (!world.contacts.empty()) {
    Vector f(static_cast<Index>(3 * world.contacts.size()));
    for (std::size_t i = 0; i < world.contacts.size(); ++i) {
      f.segment<3>(static_cast<Index>(3 * i)) = world.contacts[i].impulse;
    }
    project_on_cones(world, f);
    f = solve(world, delassus(world, h), f);
    for (std::size_t i = 0; i < world.contacts.size(); ++i) {
      world.contacts[i].impulse = f.segment<3>(static_cast<Index>(3 * i));
    }
    world.apply_impulses();
  }
  world.move(h);
  world.project_positions(settings_.projection);
}

}  // namespace lcpbench::steppers
