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

// The work of a run, found as it goes: neither its memory nor the time to the first problem grow with the number of
// trials.

namespace lcpbench {

/// One problem of a study, or consecutive steps, and the solvers that still have to run on any of them.
struct Task {
  std::size_t set = 0;
  std::int64_t trial = 0;
  std::int64_t count = 1;
  std::vector<std::size_t> solvers;
};

/// Walks through the problems of a study, or of one shard of it, and asks the store of each what is done. Consecutive
/// steps that are solved in order are one task, and a solver that lacks any of them runs on all again: its answers
/// depend on those before.
///
/// The problems come by their share of their set's trials, (trial + 1/2) / trials, and at equal shares in the order of
/// the sets: all sets advance together. Memory: O(sets x classes of their trials). Reads the store through a connection
/// of its own. Any number of threads may call it.
class PlanWalk {
 public:
  PlanWalk(const Study& study, Store& store, std::int64_t shard, std::int64_t shards);

  /// Passes problems up to the next of which the store has not all. @returns its task; nullopt when every problem was
  /// passed, or `closed` says that no more is wanted
  std::optional<Task> next(const std::function<bool()>& closed);

  /// Cells of all problems, done or not.
  std::int64_t planned() const { return planned_; }
  /// Cells of the problems passed that the store had.
  std::int64_t already_done() const { return already_done_; }
  /// `already_done` is known: every problem was passed, or the store had none.
  bool counted() const { return ended_ || !done_; }

 private:
  struct Set {
    std::string name;
    std::int64_t next = 0;  ///< the first trial that was not looked at
  };
  /// The next problem of a set.
  struct Head {
    double share = 0;
    std::size_t set = 0;
    std::int64_t trial = 0;
    std::int64_t count = 1;
    /// For a queue whose top is the greatest.
    bool operator<(const Head& other) const { return share > other.share || (share == other.share && set > other.set); }
  };

  /// Looks for the next problem of a set that this shard is dealt.
  void push_next(std::size_t set);
  /// Passes one problem. @returns its task; nullopt when the store has all of it
  std::optional<Task> step();
  /// How many answers to these problems the store has, of each solver.
  std::vector<std::int64_t> answered(const Head& head);
  /// How many of these problems a solver runs on.
  std::int64_t taken(std::size_t solver, const Head& head) const;

  const Study& study_;
  std::optional<Store> done_;  ///< what was there at the start; nullopt where that is nothing
  std::vector<std::vector<DealtClass>> deal_;  ///< of the trials that were not looked at
  std::int64_t shard_;
  std::int64_t shards_;
  std::unordered_map<std::int64_t, std::size_t> solver_of_;
  std::vector<Set> sets_;
  std::priority_queue<Head> heads_;
  std::int64_t planned_ = 0;
  std::atomic<std::int64_t> already_done_ = 0;
  std::atomic<bool> ended_ = false;
  std::mutex mutex_;
};

}  // namespace lcpbench
