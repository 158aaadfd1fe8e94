#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/spec.h"
#include "core/timed_solve.h"
#include "study/run/sweeps.h"

namespace lcpbench {

/// Largest number of trials of a set. More trials than a finite set has problems mean all its problems.
inline constexpr std::int64_t kMaxTrials = 100'000'000;

struct PlannedSet {
  std::string pattern;                 ///< a set with options, a glob over sets, or file:PATH
  std::optional<std::int64_t> trials;  ///< instead of the plan's
  std::optional<double> share;         ///< instead of `trials`: this share of the plan's, rounded up, in (0, 1]
};

struct PlannedSolver {
  Spec spec;
  std::int64_t every = 1;  ///< runs on trials 0, every, 2 every, ... of each set: a systematic subsample
  std::optional<Sweep> sweep;
  std::vector<std::string> sets;  ///< runs on sets whose full name matches one of these (* and ?); none: on all
  /// True for solvers that are left out, with a line that says so, where they are not available.
  bool optional = false;
};

/// What a study runs. Plain data; docs/reference/plans.md documents the JSON form.
struct Plan {
  std::string name;
  std::string description;
  std::uint64_t seed = 1;
  std::int64_t trials = 100;
  double time_limit_s = 10.0;      ///< on each solve, wall clock
  double repeat_until_s = kRepeatUntilS;    ///< small solves are repeated until they take this long (sweep cells are not)
  std::optional<double> budget_s;  ///< wall clock of a run: no problem is begun after it
  std::optional<double> solved_at;  ///< the verdict's bound, instead of that of each problem's kind; in (0, 1]
  std::optional<int> jobs;         ///< nullopt: one per processor
  /// Beside each run from nothing, solvers that take a start run again on consecutive steps of simulations, each from
  /// its own last answer.
  bool start_last = false;
  std::vector<PlannedSet> sets;
  std::vector<PlannedSolver> solvers;
  /// True where `sets` were replaced: a solver's pattern may then match none of them. Not in the JSON form.
  bool other_sets = false;
};

/// Reads a plan. Strict: an unknown key, a missing one, a wrong type, a value out of range, an unknown solver or sweep,
/// a bad setting is an error. Sets are looked up later, by resolve().
/// @param origin stands for the file in errors. @throws InputError, one line: origin, field, cause.
Plan parse_plan(std::string_view text, const std::string& origin);

/// The plan as JSON that parse_plan reads back; what the store records. Sweeps are spelled out.
std::string plan_json(const Plan& plan);

/// The built-in plan of that name, else the plan file. @throws InputError when there is neither.
Plan load_plan(const std::string& name_or_file);

/// A plan that is part of the program: a file of study/run/plans/.
struct BuiltinPlan {
  std::string_view name;
  std::string_view text;  ///< JSON, equal in form to a user's plan file
};

/// In the order of study/CMakeLists.txt.
extern const std::vector<BuiltinPlan> kBuiltinPlans;

std::vector<std::string> builtin_plan_names();

}  // namespace lcpbench
