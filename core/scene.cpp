#include "core/scene.h"

#include <array>

namespace lcpbench {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

/// Adds the entries of a column: the wrench [d; r x d] of d = `direction` at the contact on body_a, minus it on body_b.
void add_wrench(const RigidScene& scene, const RigidContact& contact, const Eigen::Vector3d& direction, Index column,
                Triplets& triplets) {
  const auto add = [&](int body_index, double sign) {
    if (body_index == RigidContact::kWorld) return;
    const RigidBody& body = scene.bodies[static_cast<std::size_t>(body_index)];
    const Eigen::Vector3d arm = contact.point - body.position;
    const Eigen::Vector3d torque = arm.cross(direction);
    for (int k = 0; k < 3; ++k) {
      if (direction(k) != 0) triplets.emplace_back(6 * body_index + k, column, sign * direction(k));
      if (torque(k) != 0) triplets.emplace_back(6 * body_index + 3 + k, column, sign * torque(k));
    }
  };
  add(contact.body_a, 1.0);
  add(contact.body_b, -1.0);
}

SparseMatrix assemble(Index rows, Index cols, const Triplets& triplets) {
  SparseMatrix result(rows, cols);
  result.setFromTriplets(triplets.begin(), triplets.end());
  return result;
}

}  // namespace

ContactProblem contact_problem(const RigidScene& scene) {
  const Index ngc = 6 * static_cast<Index>(scene.bodies.size());
  ContactProblem problem;
  problem.v.resize(ngc);
  BlockInertia inertia;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const RigidBody& body = scene.bodies[b];
    problem.v.segment<3>(6 * static_cast<Index>(b)) = body.linear_velocity;
    problem.v.segment<3>(6 * static_cast<Index>(b) + 3) = body.angular_velocity;
    inertia.blocks.push_back(body.mass * Matrix::Identity(3, 3));
    inertia.blocks.push_back(body.inertia);
  }
  problem.inertia = std::move(inertia);

  Triplets normals;
  Triplets tangents;
  Index column = 0;
  problem.mu.resize(static_cast<Index>(scene.contacts.size()));
  for (std::size_t c = 0; c < scene.contacts.size(); ++c) {
    const RigidContact& contact = scene.contacts[c];
    add_wrench(scene, contact, contact.normal, static_cast<Index>(c), normals);
    problem.mu(static_cast<Index>(c)) = contact.mu;
    problem.edges.push_back(contact.edges);
    const auto i = static_cast<Index>(c);
    const auto set = [](Vector& values, Index size, Index at, double value) {
      if (value == 0) return;
      if (values.size() == 0) values.setZero(size);
      values(at) = value;
    };
    set(problem.b, problem.mu.size(), i, contact.b);
    set(problem.compliance_n, problem.mu.size(), i, contact.compliance_n);
    if (contact.edges == 0) continue;
    set(problem.compliance_t, problem.mu.size(), i, contact.compliance_t);
    for (const int k : {0, 1}) set(problem.offset_t, 2 * problem.mu.size(), 2 * i + k, contact.offset_t(k));
    const Eigen::Vector3d second = contact.normal.cross(contact.tangent);
    const std::array<Eigen::Vector3d, 4> directions{contact.tangent, second, -contact.tangent, -second};
    for (const Eigen::Vector3d& direction : directions) add_wrench(scene, contact, direction, column++, tangents);
  }
  problem.N = assemble(ngc, static_cast<Index>(scene.contacts.size()), normals);
  problem.D = assemble(ngc, column, tangents);
  return problem;
}

}  // namespace lcpbench
