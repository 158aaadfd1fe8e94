#pragma once

#include <vector>

#include "core/problem.h"
#include "tests/support/contacts.h"
#include "tests/support/solving.h"

namespace lcpbench::testing {

/// The velocity that the impulses inside the friction pyramids with the least kinetic energy leave, by active_set on
/// contacts without friction whose normals are the edges of the pyramids. Where rest is a solution, it is at rest.
/// Empty where active_set fails.
inline Vector least_energy_velocity(const ContactProblem& contact) {
  const Matrix N = to_dense(contact.N);
  const Matrix D = to_dense(contact.D);
  std::vector<Vector> edges;
  std::vector<double> offsets;
  Index direction = 0;
  for (Index c = 0; c < contact.nc(); ++c) {
    const int directions = contact.edges[static_cast<std::size_t>(c)];
    if (directions == 0) edges.push_back(N.col(c));
    for (int t = 0; t < directions; ++t) edges.push_back(N.col(c) + contact.mu(c) * D.col(direction + t));
    offsets.resize(edges.size(), contact.offset(c));
    direction += directions;
  }
  const auto count = static_cast<Index>(edges.size());
  Matrix normals(contact.ngc(), count);
  for (Index j = 0; j < count; ++j) normals.col(j) = edges[static_cast<std::size_t>(j)];
  ContactProblem convex = frictionless(contact.v, normals, contact.inertia);
  if (contact.has_offset()) convex.b = Eigen::Map<const Vector>(offsets.data(), count);
  const Answer answer = solve("active_set", Problem("least energy", convex), {.time_limit_s = 10});
  return answer.claim == Claim::kSolved ? Vector(answer.velocity) : Vector();
}

}  // namespace lcpbench::testing
