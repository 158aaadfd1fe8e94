#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/timed_solve.h"
#include "generators/sets.h"
#include "study/plan.h"
#include "study/store.h"

namespace lcpbench {

struct StudySet {
  std::shared_ptr<const ProblemSet> set;
  std::int64_t trials = 0;
};

struct StudySolver {
  SolverRow row;
  std::int64_t every = 1;  ///< runs on trials that this divides
  std::function<std::unique_ptr<TimedSolver>()> open;
};

/// A plan with its sets opened and its solvers found: what the runner runs.
struct Study {
  std::uint64_t seed = 1;
  double time_limit_s = 10.0;
  double repeat_until_s = 0;
  std::optional<double> budget_s;
  std::vector<StudySet> sets;
  std::vector<StudySolver> solvers;
  std::vector<std::string> skipped;  ///< optional solvers left out, "name: reason"
};

/// The row of a solver as this process would run it.
SolverRow solver_row(const Spec& solver, const std::string& sweep = {});

/// Opens the sets, lays out the sweeps and finds the solvers of a plan. Finite sets are cut to the problems they have;
/// the same set or solver named twice counts once.
/// @throws InputError for unknown sets, one set with two numbers of trials, and unavailable solvers that are not
/// optional.
Study resolve(const Plan& plan);

}  // namespace lcpbench
