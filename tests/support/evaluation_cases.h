#pragma once

#include <cmath>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

#include "core/scene.h"
#include "study/evaluation/evaluation.h"
#include "tests/support/contacts.h"

// Problems with answers worked out by hand, and draws that are the same everywhere, for the tests of the evaluation.

namespace lcpbench {

using testing::Draw;
using testing::frictionless;
using testing::in_dense_matrices;
using testing::vec;

inline constexpr double kInf = std::numeric_limits<double>::infinity();
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

inline Answer answer(Vector z, Claim claim = Claim::kSolved) {
  Answer result;
  result.claim = claim;
  result.z = std::move(z);
  return result;
}

inline Errors evaluate(const Problem& problem, const Vector& z) { return Evaluator(problem).errors(answer(z)); }

// A particle of mass 1 in the plane that meets the ground y = 0, friction along x.
// z = [f_n; f_+, f_-; lambda], w = [v+_y; lambda + v+_x, lambda - v+_x; mu f_n - f_+ - f_-].
inline Problem particle(double vx, double vy, double mu) {
  ContactProblem problem;
  problem.v = vec({vx, vy});
  problem.N = Matrix(vec({0, 1}));
  Matrix D(2, 2);
  D << 1, -1, 0, 0;
  problem.D = D;
  problem.edges = {2};
  problem.mu = vec({mu});
  problem.inertia = DenseInertia{Matrix::Identity(2, 2)};
  return Problem("particle", problem);
}

inline Problem sliding_particle() { return particle(2, -1, 0.5); }
inline Vector sliding_answer() { return vec({1, 0, 0.5, 1.5}); }

// A flat square plate of mass 1 that lands on its four corners while it slides along x.
inline RigidScene plate(int copies = 1) {
  RigidScene scene;
  for (int b = 0; b < copies; ++b) {
    RigidBody body;
    body.linear_velocity = {2, 0, -1};
    body.position = {4.0 * b, 0, 0};
    scene.bodies.push_back(body);
    for (const double x : {-1.0, 1.0}) {
      for (const double y : {-1.0, 1.0}) {
        RigidContact contact;
        contact.body_a = b;
        contact.point = body.position + Eigen::Vector3d(x, y, 0);
        contact.mu = 0.5;
        contact.edges = 4;
        scene.contacts.push_back(contact);
      }
    }
  }
  return scene;
}

// Each corner takes a quarter of the impulse and half of that as friction against the sliding, which goes on at 1.5
// m/s.
inline Vector plate_answer(int copies = 1) {
  const Index contacts = 4 * copies;
  Vector z = Vector::Zero(6 * contacts);
  for (Index c = 0; c < contacts; ++c) {
    z(c) = 0.25;
    z(contacts + 4 * c + 2) = 0.125;
    z(5 * contacts + c) = 1.5;
  }
  return z;
}

inline void expect_exact(const Errors& errors) {
  EXPECT_TRUE(errors.usable);
  EXPECT_TRUE(errors.solved);
  EXPECT_EQ(errors.velocity_residual_m_per_s, 0);
  EXPECT_EQ(errors.velocity_residual_relative, 0);
  EXPECT_EQ(errors.natural_residual, 0);
  EXPECT_EQ(errors.violation_m_per_s, 0);
  EXPECT_EQ(errors.complementarity_j, 0);
  EXPECT_EQ(errors.cone_violation, 0);
}

inline void expect_no_measure(const Errors& errors) {
  EXPECT_FALSE(errors.usable);
  EXPECT_FALSE(errors.solved);
  EXPECT_FALSE(errors.criterion);
  for (const double measure :
       {errors.velocity_residual_m_per_s, errors.velocity_residual_relative, errors.natural_residual,
        errors.backward_row_norm, errors.forward_velocity, errors.violation_m_per_s,
        errors.work_gain_j, errors.complementarity_j, errors.cone_violation, errors.min_z, errors.velocity_mismatch}) {
    EXPECT_TRUE(std::isnan(measure));
  }
}

// A random frictional problem whose M is exact in double (G a power of two), so that form_lcp spells the same problem.
inline ContactProblem random_frictional(Draw& draw, Index ngc, Index contacts, int edges) {
  ContactProblem problem;
  problem.v = draw.vector(ngc);
  problem.N = draw.matrix(ngc, contacts);
  Matrix D(ngc, contacts * edges);
  for (Index c = 0; c < contacts; ++c) {
    const Matrix half = draw.matrix(ngc, edges / 2);
    D.middleCols(c * edges, edges) << half, -half;
  }
  problem.D = D;
  problem.edges.assign(static_cast<std::size_t>(contacts), edges);
  problem.mu = draw.vector(contacts).cwiseAbs();
  problem.inertia = DenseInertia{0.25 * Matrix::Identity(ngc, ngc)};
  return problem;
}

// Entries of every kind: large, zero, tiny of either sign.
inline Vector random_answer(Draw& draw, Index size) {
  Vector z(size);
  for (double& value : z) {
    const std::uint64_t kind = draw.bits() % 4;
    const double magnitude = std::abs(draw.uniform()) + 0x1p-11;
    if (kind == 0) value = 0;
    if (kind == 1) value = magnitude;
    if (kind == 2) value = std::ldexp(magnitude, -static_cast<int>(draw.bits() % 50));
    if (kind == 3) value = std::ldexp(draw.uniform(), -10 - static_cast<int>(draw.bits() % 40));
  }
  return z;
}

}  // namespace lcpbench
