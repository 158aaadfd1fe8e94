#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <queue>
#include <string>
#include <unordered_map>
#include <vector>

#include "study/store/store.h"
#include "study/run/study.h"

// The work of a run, found while it runs: neither the memory nor the time before the first problem grows with the
// number of trials.

namespace lcpbench {

/// One problem of a study, or consecutive steps of a simulation, and the solvers that still have to run there.
struct Task {
  std::size_t set = 0;               ///< index in Study::sets
  std::int64_t trial = 0;            ///< the first
  std::int64_t count = 1;            ///< number of trials
  std::vector<std::size_t> solvers;  ///< indices in Study::solvers; each runs on those of the trials that it takes
};

/// Walks through the problems of one shard of a study, and asks the store which answers to each it has. Consecutive
/// steps that are solved in order are one task. A solver without an answer to one of them runs on all of them again,
/// because its answers may depend on those before.
///
/// The problems come in ascending order of (trial + 1/2) / trials, their share of their set, and at equal shares in the
/// order of the sets: all sets advance together. Memory: O(solvers + classes of trials of all sets). Reads the store
/// through a connection of its own. Any number of threads may call its members.
class PlanWalk {
 public:
  /// @param study  must outlive this object  @param shard  from 0 to shards - 1
  PlanWalk(const Study& study, Store& store, std::int64_t shard, std::int64_t shards);

  /// Skips what the store has complete. @returns the next task; nullopt after the last one, or when `closed`, which is
  /// asked before each problem, returns true
  std::optional<Task> next(const std::function<bool()>& closed);

  /// Answers that the shard asks for, done or not: one for each problem and solver, or cell of a solver's sweep.
  std::int64_t planned() const { return planned_; }
  /// How many of these the store had and no task asks for again, of the problems passed so far.
  std::int64_t already_done() const { return already_done_; }
  /// Whether already_done() is final: every problem was passed, or the store had no answers at the start.
  bool counted() const { return ended_ || !done_; }

 private:
  struct Set {
    std::string name;
    std::int64_t next = 0;  ///< the first trial that was not looked at
  };
  /// The next problem of a set, or its next consecutive steps.
  struct Head {
    double share = 0;
    std::size_t set = 0;
    std::int64_t trial = 0;
    std::int64_t count = 1;
    /// Reversed: the top of std::priority_queue is the greatest, and the least share is to come first.
    bool operator<(const Head& other) const { return share > other.share || (share == other.share && set > other.set); }
  };

  /// Adds the set's next problem that is dealt to this shard to heads_, if there is one.
  void push_next(std::size_t set);
  /// Takes the first of heads_. @returns its task; nullopt when the store has all of it. @pre heads_ is not empty
  std::optional<Task> step();
  /// How many of these problems the store has an answer to, for each solver.
  std::vector<std::int64_t> answered(const Head& head);
  /// How many of these problems a solver runs on.
  std::int64_t taken(std::size_t solver, const Head& head) const;

  const Study& study_;
  std::optional<Store> done_;  ///< the store, for reading; nullopt if it had no answers at the start
  std::vector<std::vector<DealtClass>> deal_;  ///< by set; `first` is the shard that gets the class's next trial
  std::int64_t shard_;
  std::int64_t shards_;
  std::unordered_map<std::int64_t, std::size_t> solver_of_;  ///< by the id of its row: index in Study::solvers
  std::vector<Set> sets_;
  std::priority_queue<Head> heads_;
  std::int64_t planned_ = 0;
  std::atomic<std::int64_t> already_done_ = 0;
  std::atomic<bool> ended_ = false;
  std::mutex mutex_;
};

}  // namespace lcpbench
