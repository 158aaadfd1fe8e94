#pragma once

#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "study/evaluation/evaluation.h"

// What the tests of `auto` ask of its answers.

namespace lcpbench {
SolverDefinition lcpbench_solver_auto();

namespace testing {

inline std::unique_ptr<Solver> auto_solver(const Options& options = {}) { return lcpbench_solver_auto().make(options); }

inline Answer solve(Solver& solver, const SolveRequest& request = {}) {
  Answer answer;
  solver.solve(request, answer);
  return answer;
}

inline Answer solve(const Problem& problem, const Options& options = {}, const SolveRequest& request = {}) {
  const auto solver = auto_solver(options);
  solver->load(problem);
  return solve(*solver, request);
}

/// By a method that takes the whole at once: the reference for the velocity of the parts.
inline Answer solve_whole(const Problem& problem) {
  const auto solver = make_solver(parse_spec(problem.contact()->frictional() ? "contact_lemke" : "active_set"));
  solver->load(problem);
  return solve(*solver);
}

inline void expect_verified(const Problem& problem, const Answer& answer, const std::string& what) {
  ASSERT_EQ(answer.claim, Claim::kSolved) << what << ": " << answer.detail;
  const Errors errors = Evaluator(problem).errors(answer);
  EXPECT_TRUE(errors.solved) << what << ": " << answer.detail;
  EXPECT_LE(errors.velocity_residual_relative, 1e-9) << what << ": " << answer.detail;
}

inline void expect_claimed(const Problem& problem, const Answer& answer, const std::string& methods) {
  ASSERT_EQ(answer.claim, Claim::kSolved) << problem.name() << ": " << answer.detail;
  EXPECT_TRUE(Evaluator(problem).errors(answer).solved) << problem.name() << ": " << answer.detail;
  EXPECT_NE(answer.detail.find(methods), std::string::npos) << problem.name() << ": " << answer.detail;
}

inline double velocity_difference(const Problem& problem, const Answer& a, const Answer& b) {
  const ContactProblem& contact = *problem.contact();
  return (post_impact_velocity(contact, a.z) - post_impact_velocity(contact, b.z)).lpNorm<Eigen::Infinity>();
}

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// A further coordinate and a contact on it: an island of its own.
inline Problem with_an_island_more(const Problem& problem) {
  ContactProblem contact = *problem.contact();
  const Index ngc = contact.ngc();
  const auto& N = std::get<Matrix>(contact.N);
  Matrix G = Matrix::Identity(ngc + 1, ngc + 1);
  G.topLeftCorner(ngc, ngc) = std::get<DenseInertia>(contact.inertia).G;
  Matrix normals = Matrix::Zero(ngc + 1, N.cols() + 1);
  normals.topLeftCorner(ngc, N.cols()) = N;
  normals(ngc, N.cols()) = 1;
  contact.inertia = DenseInertia{G};
  contact.N = normals;
  contact.D = Matrix(ngc + 1, 0);
  contact.v.conservativeResize(ngc + 1);
  contact.v(ngc) = -contact.v.head(ngc).lpNorm<Eigen::Infinity>();
  contact.edges.push_back(0);
  contact.mu = Vector::Zero(N.cols() + 1);
  return Problem(problem.name(), contact);
}

}  // namespace testing
}  // namespace lcpbench
