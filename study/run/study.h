#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/timed_solve.h"
#include "generators/sets.h"
#include "study/run/open_solver.h"
#include "study/run/plan.h"
#include "study/run/shards.h"
#include "study/store/store.h"

namespace lcpbench {

struct StudySet {
  std::shared_ptr<const ProblemSet> set;
  std::int64_t trials = 0;
  bool in_order = false;  ///< one thread solves consecutive steps of it, in their order
};

/// A solver, or a solver's sweep, and the trials that it runs on.
struct StudySolver {
  SolverRow row;
  std::vector<SolverRow> cells;  ///< of a sweep; empty for a solver by itself
  std::function<std::unique_ptr<TimedSolver>()> open;
  std::function<std::unique_ptr<SweptSolver>()> open_swept;  ///< instead of `open`, for a sweep
  /// For each set of the study the steps: the solver runs on the trials that one of them divides. On a set without an
  /// entry it does not run.
  std::vector<std::vector<std::int64_t>> every;
  bool from_last = false;  ///< starts from its own answer to the step before

  bool swept() const { return !cells.empty(); }
  std::int64_t cell_count() const { return swept() ? static_cast<std::int64_t>(cells.size()) : 1; }
  bool takes(std::size_t set, std::int64_t trial) const;
};

/// A plan with its sets opened and its solvers found: what the runner runs.
struct Study {
  std::uint64_t seed = 1;
  double time_limit_s = 10.0;
  double repeat_until_s = 0;
  std::optional<double> budget_s;
  std::optional<double> solved_at;
  std::vector<StudySet> sets;
  std::vector<StudySolver> solvers;
  std::vector<StudySolver> left_out;  ///< optional solvers that are not available: not to be opened
  /// For the user: "name: reason" of these, and the solvers that Plan::start_last cannot start from their last answer.
  std::vector<std::string> skipped;
  MeasuredCosts costs;  ///< by which problems are dealt to shards; none: each solver costs the same
};

/// The row of a solver as this process would run it.
SolverRow solver_row(const Spec& solver, const std::string& sweep = {});

/// Marks, in the settings of its row, a solver that starts from its own answer to the step before.
inline constexpr const char* kStartLast = "start=last";

/// Opens the sets, lays out the sweeps and finds the solvers of a plan. Finite sets are cut to the problems they have.
/// The same set named twice counts once; a solver named more than once runs on the trials that any of its entries
/// names. With Plan::start_last there is a second solver, of the settings kStartLast, for each that takes a start and
/// runs on every trial.
/// @throws InputError for unknown sets, one set with two numbers of trials, a solver's pattern that matches no set of
/// the plan (unless `Plan::other_sets`), two grids under one name, unavailable solvers that are not optional, and plans
/// with Plan::start_last none of whose sets has consecutive steps.
Study resolve(const Plan& plan);

}  // namespace lcpbench
