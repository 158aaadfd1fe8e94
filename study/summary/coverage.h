#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "study/run/study.h"

namespace lcpbench {

/// part / whole; NaN where the whole is not above 0.
double share_of(std::int64_t part, std::int64_t whole);

/// A set of which less than this share of its planned cells is done counts as thin.
inline constexpr double kThinBelow = 0.9;

struct RunSummary {
  std::string started;
  nlohmann::ordered_json provenance;
};

/// How many of the cells (set x trial x solver parameterisation) that its runs planned a store holds.
///
/// The plan is the union of the plans of all runs, each with all its shards: a run that is repeated or resumed plans
/// nothing new, one with more trials or solvers plans more, and the store of one shard of two holds half of the plan. A
/// cell is done when any version and any instruction-set level of its solver answered it.
struct Coverage {
  struct Set {
    std::string name;
    std::int64_t planned = 0;
    std::int64_t done = 0;

    double share() const;
    bool thin() const;
  };

  bool known = false;  ///< false: some run recorded no plan, and the numbers below are zero
  std::int64_t planned = 0;
  std::int64_t done = 0;
  std::vector<Set> sets;  ///< in natural order of names
  /// How many planned cells the store lacks of each solver that a run left out, by the run's line "name: reason".
  std::map<std::string, std::int64_t> left_out;

  /// done / planned; NaN where it is not known, or nothing was planned.
  double share() const;
  /// Not known is not incomplete.
  bool incomplete() const { return known && done < planned; }
  /// The thin sets, thinnest first.
  std::vector<Set> thin_sets() const;
};

/// What a run of this study plans, for its provenance: the sets with their trials, the solvers with their number of
/// cells and the trials of each set that they run on.
nlohmann::ordered_json planned_cells(const Study& study);

/// A solver on the problems of a set, whatever its version and level. Names as in the store.
struct Work {
  std::string set;
  std::string solver;  ///< SolverRow::text()
  std::string sweep;

  auto operator<=>(const Work&) const = default;
};

/// The problems that some version of a solver answered.
struct Done {
  std::int64_t problems = 0;
  std::int64_t last = -1;

  /// The answers to one problem come one after the other.
  void add(std::int64_t problem) {
    if (problem != last) ++problems;
    last = problem;
  }
};

/// Compares what the runs of a store planned with what is done.
Coverage coverage_of(const std::vector<RunSummary>& runs, const std::map<Work, Done>& done);

/// `coverage` of summary.json. Where it is not known, `planned`, `done` and `share` are null, `left_out` and `sets`
/// empty.
nlohmann::ordered_json coverage_json(const Coverage& coverage);

}  // namespace lcpbench
