#pragma once

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "core/spec.h"
#include "study/evaluation/evaluation.h"

// Solvers by name, and what tests ask of their answers.

namespace lcpbench::testing {

inline Answer solve(Solver& solver, const SolveRequest& request = {}) {
  Answer answer;
  solver.solve(request, answer);
  return answer;
}

/// By a solver of its own. @param solver  name and settings
inline Answer solve(const std::string& solver, const Problem& problem, const SolveRequest& request = {}) {
  const auto made = make_solver(parse_spec(solver));
  made->load(problem);
  return solve(*made, request);
}

inline std::vector<std::string> native_solvers() {
  std::vector<std::string> names;
  for (const RegisteredSolver& solver : registered_solvers()) {
    if (solver.native()) names.push_back(solver.definition.name);
  }
  return names;
}

/// Claimed solved, which the evaluation confirms, with a velocity residual of at most `most`.
inline void expect_solved(const Problem& problem, const Answer& answer, double most = kSolvedVelocityResidual,
                          const std::string& what = "") {
  ASSERT_EQ(answer.claim, Claim::kSolved) << problem.name() << " " << what << ": " << answer.detail;
  const Errors errors = Evaluator(problem).errors(answer);
  EXPECT_TRUE(errors.solved) << problem.name() << " " << what << ": " << answer.detail;
  if (problem.contact() == nullptr) return;
  EXPECT_LE(errors.velocity_residual_relative, most) << problem.name() << " " << what << ": " << answer.detail;
}

/// What is claimed solved is solved, however the claim comes out.
inline void expect_honest(const Problem& problem, const Answer& answer, const std::string& what = "") {
  if (answer.claim == Claim::kSolved) expect_solved(problem, answer, kSolvedVelocityResidual, what);
}

}  // namespace lcpbench::testing
