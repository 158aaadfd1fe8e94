#pragma once

#include <cctype>
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
inline Answer solve(const Spec& solver, const Problem& problem, const SolveRequest& request = {}) {
  const auto made = make_solver(solver);
  made->load(problem);
  return solve(*made, request);
}
inline Answer solve(const std::string& solver, const Problem& problem, const SolveRequest& request = {}) {
  return solve(parse_spec(solver), problem, request);
}

inline std::vector<std::string> native_solvers() {
  std::vector<std::string> names;
  for (const RegisteredSolver& solver : registered_solvers()) {
    if (solver.native()) names.push_back(solver.definition.name);
  }
  return names;
}

/// The paper's sets whose inertia is regular, so that every problem has a solution. Experiment 6 has those of 5.
inline std::vector<std::string> full_rank_sets() {
  std::vector<std::string> names{"paper/monotone/exp1", "paper/copositive/exp1"};
  for (const char* kind : {"monotone", "copositive"}) {
    for (const char* experiment : {"exp2", "exp5-1e5", "exp5-1e8", "exp5-1e10"}) {
      for (const char* redundancy : {"multiple", "combination"}) {
        names.push_back(std::string("paper/") + kind + "/" + experiment + "{redundancy=" + redundancy + "}");
      }
    }
  }
  return names;
}

/// The set's name as that of a test.
inline std::string paper_set_name(const ::testing::TestParamInfo<std::string>& test) {
  std::string name = test.param.substr(std::string("paper/").size());
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return name;
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
