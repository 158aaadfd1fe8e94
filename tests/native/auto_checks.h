#pragma once

#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "core/compliance.h"
#include "study/evaluation/fastest_contact.h"
#include "tests/support/least_energy_velocity.h"
#include "tests/support/solving.h"

// What the tests of `auto` ask of its answers, and a problem that they share.

namespace lcpbench::testing {

inline std::unique_ptr<Solver> auto_solver(const Options& options = {}) { return make_solver({"auto", options}); }

inline Answer solve(const Problem& problem, const Options& options = {}, const SolveRequest& request = {}) {
  const auto solver = auto_solver(options);
  solver->load(problem);
  return solve(*solver, request);
}

/// By a method that takes the whole at once: the reference for the velocity of the parts.
inline Answer solve_whole(const Problem& problem) {
  return solve(problem.contact()->frictional() ? "contact_lemke" : "active_set", problem);
}

inline void expect_verified(const Problem& problem, const Answer& answer, const std::string& what) {
  expect_solved(problem, answer, 1e-9, what);
}

inline double velocity_difference(const Problem& problem, const Answer& a, const Answer& b) {
  const ContactProblem& contact = *problem.contact();
  return (post_impact_velocity(contact, a.z) - post_impact_velocity(contact, b.z)).lpNorm<Eigen::Infinity>();
}

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Where the velocity of the least energy is at rest, so is the answer's.
inline void expect_rest_where_it_is_a_solution(const ContactProblem& contact, const Answer& answer, const std::string& what) {
  const double before = fastest_contact(contact, contact.v).m_per_s;
  const Vector rest = least_energy_velocity(contact);
  if (rest.size() == 0 || fastest_contact(contact, rest).m_per_s > 1e-9 * before) return;
  const double after = fastest_contact(contact, post_impact_velocity(contact, answer.z)).m_per_s;
  EXPECT_LE(after, 1e-8 * before) << what << ": " << answer.detail;
}

/// A cube of 50 g and edge 4 cm between two fingers of 5 kg that press with 20 N each, four contacts at each; a step of
/// 2 ms. Coordinates: the six of the cube, and one of each finger.
inline ContactProblem pinched_cube() {
  ContactProblem contact;
  contact.v = Vector{{0, 0, -9.81 * 0.002, 0, 0, 0, 0.008, -0.008}};
  Matrix N = Matrix::Zero(8, 8), D = Matrix::Zero(8, 32);
  for (Index c = 0; c < 8; ++c) {
    const double side = c < 4 ? -1 : 1;
    const Eigen::Vector3d point(0.02 * side, c % 2 == 0 ? -0.01 : 0.01, c % 4 < 2 ? -0.01 : 0.01);
    const Eigen::Vector3d normal(-side, 0, 0);
    N.col(c) << normal, point.cross(normal), side < 0 ? -1 : 0, side < 0 ? 0 : 1;
    for (Index k = 0; k < 4; ++k) {
      const auto along = edge_direction(k, 4);
      const Eigen::Vector3d tangent(0, along[0], along[1]);
      D.col(4 * c + k).head<6>() << tangent, point.cross(tangent);
    }
  }
  contact.N = N;
  contact.D = D;
  contact.edges.assign(8, 4);
  contact.mu = Vector::Constant(8, 0.5);
  const double inertia = 0.05 * 0.04 * 0.04 / 6;
  contact.inertia = DenseInertia{Vector{{0.05, 0.05, 0.05, inertia, inertia, inertia, 5, 5}}.asDiagonal()};
  return contact;
}

}  // namespace lcpbench::testing
