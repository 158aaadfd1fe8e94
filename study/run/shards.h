#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "study/store/sqlite.h"

namespace lcpbench {

struct Study;
struct StudySolver;

/// Processor time of all cells of a solver on one problem of a set, as measured [s].
struct MeasuredCost {
  double mean = 0;
  double deviation = 0;  ///< from problem to problem; the mean itself where only one was measured
  std::int64_t problems = 0;
};

/// What a run has cost, for what another run of the same plan will.
struct MeasuredCosts {
  /// By names of set, solver with settings, and sweep.
  std::map<std::tuple<std::string, std::string, std::string>, MeasuredCost> cells;
  double overhead = 0;            ///< processor time of the run over that of its cells; 0: not recorded
  double memory_bytes = 0;        ///< the most that it had, its workers included; 0: not recorded
  int jobs = 1;                   ///< threads that it had then

  const MeasuredCost* of(const std::string& set, const StudySolver& solver) const;
};

/// Reads what the runs of a store cost. @throws InputError when the store cannot be read.
MeasuredCosts measured_costs(sqlite::Database& store);

/// Deals the problems of a study to its shards.
///
/// Problems of one set that the same solvers run on are a class. The classes are put one after another, the dearest
/// first, and their problems are dealt in turn. Thus every shard gets equally many problems of each class, and of all
/// together, but for one; where the costs are known, no two shards differ by more than the dearest problem in expected
/// cost. Solvers that are not available here count too: every machine deals alike.
class Deal {
 public:
  struct Class {
    std::size_t set = 0;
    std::int64_t multiple = 0;  ///< of the steps, see common_multiple()
    std::int64_t problems = 0;  ///< in all shards
    std::int64_t first = 0;     ///< the shard that gets the first of them
    double cost = 0;            ///< that orders the classes: measured, or else the number of solvers that run
  };

  Deal(const Study& study, std::int64_t shards);

  const std::vector<Class>& classes() const { return classes_; }
  /// How many problems of a class a shard gets.
  std::int64_t problems(const Class& each, std::int64_t shard) const;
  /// The steps of all solvers on a set, each once.
  const std::vector<std::int64_t>& steps(std::size_t set) const { return steps_[set]; }

 private:
  std::int64_t shards_;
  std::vector<std::vector<std::int64_t>> steps_;
  std::vector<Class> classes_;
};

/// What a shard will cost.
struct ShardEstimate {
  std::int64_t problems = 0;
  std::int64_t cells = 0;
  double processor_s = 0;
  double error_s = 0;             ///< two standard deviations: of the problems that it draws, and of the measured means
  std::int64_t not_measured = 0;  ///< cells of solvers that were not measured on their set: not in the estimate
};

std::vector<ShardEstimate> estimate_shards(const Study& study, std::int64_t shards);

/// Cells of this study that a store has.
std::int64_t done_cells(const Study& study, sqlite::Database& store);

}  // namespace lcpbench
