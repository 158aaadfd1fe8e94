#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "study/store/sqlite.h"

namespace lcpbench {

// A shard is one of N parts of a study (`run --shard I/N`): its problems, run into a store of its own.

struct Study;
struct StudySolver;

/// Measured processor time of all cells of a solver on one problem of a set [s].
struct MeasuredCost {
  double mean = 0;
  double deviation = 0;  ///< standard, from problem to problem; the mean itself where only one was measured
  double problems = 0;      ///< how many were measured
};

/// What the runs of a store cost, from which the cost of other runs of the plan is estimated.
struct MeasuredCosts {
  /// By names of set, solver with settings, and sweep.
  std::map<std::tuple<std::string, std::string, std::string>, MeasuredCost> cells;
  double paid = 1;          ///< processor time of the runs after their starts, over that of all cells: above 1 for work
                            ///< that is not timed
  double start_s = 0;       ///< processor time of a run before its first problem, the mean
  double memory_bytes = 0;  ///< of the run that had the most, its workers included
  int jobs = 1;             ///< threads of that run

  const MeasuredCost* of(const std::string& set, const StudySolver& solver) const;
};

/// Reads what the runs of a store cost. @throws InputError when the store cannot be read, or no run in it ended
MeasuredCosts measured_costs(sqlite::Database& store);

/// Trials of a set on which the same solvers run. A solver runs on the trials that its steps divide (the field `every`
/// of a plan), so two trials are in one class if the same steps divide them. Of the steps 2 and 3, the trials 0, 6, 12,
/// ... are one class, the other even ones another, and 3, 9, 15, ... the third.
struct TrialClass {
  /// The least common multiple of the steps that divide the class's trials; for the class of trial 0, which all steps
  /// divide, at most the number of trials of the set.
  std::int64_t multiple = 0;
  std::int64_t trial = 0;  ///< one of the class
  std::int64_t count = 0;  ///< its number of trials
};

/// The classes of the trials in [0, trials) that at least one step divides, by falling multiple: a trial belongs to the
/// first class whose multiple divides it. Time grows with the least common multiple of the steps, or with the number of
/// trials where that is less. @pre every step >= 1
std::vector<TrialClass> trial_classes(std::int64_t trials, const std::vector<std::int64_t>& steps);

/// How many of the trials in [0, trials) at least one of the steps divides. @pre every step >= 1
std::int64_t count_trials(std::int64_t trials, const std::vector<std::int64_t>& steps);

/// Problems of one set that the same solvers run on, dealt to the shards in turn.
struct DealtClass : TrialClass {
  std::int64_t first = 0;  ///< the shard that gets the first of them
  bool whole = false;      ///< it gets all of them

  /// How many of them a shard gets.
  std::int64_t dealt_to(std::int64_t shard, std::int64_t shards) const {
    if (whole) return shard == first ? count : 0;
    return (count + shards - 1 - (shard - first + shards) % shards) / shards;
  }
};

/// Deals the problems of a study to its shards. @returns the classes of each set, by falling multiple
///
/// A set of consecutive steps that are solved in order goes to one shard as a whole, whatever it costs, and the next
/// such set to the next shard. The classes of all other sets are put one after another, those with the most expensive
/// problems first, and their problems are dealt in turn. So the shards differ by at most one in their numbers of
/// problems of each class, and of all these problems together, and in the expected cost of these by at most that of the
/// most expensive one. Without measured costs, a problem costs one for each solver that runs on it. Solvers that are
/// not available here count too, so that every machine deals alike. @pre shards >= 1
std::vector<std::vector<DealtClass>> deal_problems(const Study& study, std::int64_t shards);

/// What a shard will cost.
struct ShardEstimate {
  std::int64_t cells = 0;
  double processor_s = 0;
  double error_s = 0;  ///< two standard deviations: of the problems that it draws, and of the measured means
  double serial_s = 0;  ///< the most, error included, that one thread does of it: a set that is solved in order
};

/// @throws InputError when a solver's cost on a set was not measured
std::vector<ShardEstimate> estimate_shards(const Study& study, std::int64_t shards);

/// The number of this study's cells that a store has, by any version of their solvers. Counts trials that `every`
/// leaves out, too, if the store has them.
std::int64_t done_cells(const Study& study, sqlite::Database& store);

}  // namespace lcpbench
