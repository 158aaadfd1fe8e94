#pragma once

#include <csignal>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "study/store/store.h"
#include "study/run/study.h"

namespace lcpbench {

/// How far a run has come.
struct Progress {
  std::int64_t done = 0;   ///< cells finished by this run
  std::int64_t total = 0;  ///< cells this run has to do, as far as is known: see RunOutcome::counted
  double elapsed_s = 0;
  const std::string* set = nullptr;  ///< of the last problem; nullptr before the first
};

struct RunOptions {
  int jobs = 1;
  std::int64_t shard = 0;  ///< runs the problems of this one of the shards, see study/run/shards.h
  std::int64_t shards = 1;
  bool store_is_kept = true;  ///< false: errors do not tell how to go on from the store
  /// Set to non-zero from outside (a signal handler) to end the run in good order.
  const volatile std::sig_atomic_t* stop = nullptr;
  /// Called by the thread that called run_study, some ten times a second.
  std::function<void(const Progress&)> on_progress;
  /// Called by that thread now and then, first after some seconds, with all finished cells in the store.
  std::function<void(Store&)> on_partial_results;
};

enum class RunEnd { kComplete, kOutOfBudget, kStopped };

struct RunOutcome {
  RunEnd end = RunEnd::kComplete;
  std::int64_t already_done = 0;  ///< cells that the store had before, of the problems that the run came to
  /// `already_done` and `progress.total` are final. A run that ends early does not ask the store about the rest.
  bool counted = false;
  Progress progress;
  std::vector<std::string> left_out;  ///< why, for each problem that could not be read: sorted
};

/// Runs every cell (set x trial x solver parameterisation) of a study that the store does not have yet.
///
/// A problem is generated once; its solvers run one after the other in an order rotated by the trial, so that drifts of
/// the machine hit all alike. Trials of all sets advance together: a run that ends early has about the same share of
/// each set. `jobs` threads take problems from one queue, each with solvers, workers and evaluators of its own; the
/// calling thread alone writes, in transactions of at most about a second. Neither the number of threads nor their
/// order, sharding or resuming changes a row but for `timings` and `runs`.
///
/// A sweep on a problem is one unit of work: written with all its cells or not at all. Equal answers to one problem
/// (bit for bit, whoever gave them) are verified once. A problem that a solver denies without a proof is settled by
/// exact arithmetic where that is cheap (study/certificates/judge.h), and the store keeps the proof. Whatever a solver
/// does, it leaves a row. The work is found as it goes (study/run/work_queue.h): neither the memory nor the time to the
/// first problem grow with the number of trials.
/// A problem that cannot be read is left out, and the run goes on: see RunOutcome::left_out.
/// @throws InputError where no problem can be read; what generating, opening a solver or the store throws, after
/// committing what was done.
RunOutcome run_study(const Study& study, Store& store, const RunOptions& options);

}  // namespace lcpbench
