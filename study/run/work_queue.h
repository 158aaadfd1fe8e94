#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
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

/// One problem of a study, or consecutive steps, and the solvers that still have to run on them.
struct Task {
  std::size_t set = 0;
  std::int64_t trial = 0;
  std::int64_t count = 1;
  std::vector<std::uint32_t> solvers;  ///< empty: all that the trial takes
};

/// Walks through the problems of a study, or of one shard of it, and asks the store of each what is done. Consecutive
/// steps that are solved in order are one task, and a solver that lacks any of them runs on all again: its answers
/// depend on those before.
///
/// The problems come by their share of their set's trials, (trial + 1/2) / trials, and at equal shares in the order of
/// the sets: all sets advance together. Memory: O(sets x classes of their trials). Uses the store in step() alone.
class PlanWalk {
 public:
  PlanWalk(const Study& study, Store& store, std::int64_t shard, std::int64_t shards);

  /// Every problem was passed.
  bool ended() const { return heads_.empty(); }
  /// Passes one problem. @returns its task; nullopt when the store has all of it. @pre !ended()
  std::optional<Task> step();

  /// Cells of all problems, done or not.
  std::int64_t planned() const { return planned_; }
  /// Cells of the problems passed that the store had.
  std::int64_t already_done() const { return already_done_; }
  /// `already_done` is known: every problem was passed, or the store had none.
  bool counted() const { return ended() || !resuming_; }

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
  /// Marks in is_done_ the solvers whose answers to all of these problems the store has. @returns their cells
  std::int64_t look_up(const Head& head);
  /// The problems that a solver runs on.
  std::int64_t taken(std::size_t solver, const Head& head) const;

  const Study& study_;
  Store& store_;
  std::vector<std::vector<DealtClass>> deal_;  ///< of the trials that were not looked at
  std::int64_t shard_;
  std::int64_t shards_;
  bool resuming_;
  std::unordered_map<std::int64_t, std::uint32_t> solver_of_;
  std::vector<Set> sets_;
  std::priority_queue<Head> heads_;
  std::vector<bool> is_done_;
  std::int64_t planned_ = 0;
  std::int64_t already_done_ = 0;
};

/// Tasks on their way from the thread that finds them to those that take them.
class TaskQueue {
 public:
  void push(Task task);
  /// Waits for a task; nullopt when none will come, or the queue is closed.
  std::optional<Task> pop();
  /// No more will come; those in the queue are still taken.
  void end();
  /// Nothing more is taken.
  void close();
  std::size_t size();

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task> tasks_;
  bool ended_ = false;
};

/// Closes the queue when it goes: threads that wait for a task end, whatever is thrown.
class ClosedAtTheEnd {
 public:
  explicit ClosedAtTheEnd(TaskQueue& queue) : queue_(queue) {}
  ~ClosedAtTheEnd() { queue_.close(); }
  ClosedAtTheEnd(const ClosedAtTheEnd&) = delete;
  ClosedAtTheEnd& operator=(const ClosedAtTheEnd&) = delete;

 private:
  TaskQueue& queue_;
};

}  // namespace lcpbench
