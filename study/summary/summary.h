#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "study/output/text_table.h"
#include "study/summary/coverage.h"
#include "study/statistics/statistics.h"
#include "study/store/store.h"

namespace lcpbench {

inline constexpr std::size_t kClaims = 7;

/// Every claim, in the order of the enum.
inline constexpr std::array<Claim, kClaims> kAllClaims{
    Claim::kSolved,           Claim::kUnsolvable,  Claim::kIterationLimit, Claim::kTimeLimit,
    Claim::kNumericalFailure, Claim::kUnsupported, Claim::kCrashed};

/// One problem set of a store, with properties that its name and its problems show.
struct SetSummary {
  std::string name;
  std::int64_t problems = 0;
  std::int64_t last_trial = 0;   ///< the largest number of a problem
  bool contact = false;          ///< every problem is a contact problem (bare LCPs have no velocity residual)
  bool bare = false;             ///< every problem is a bare LCP
  bool free_bodies = false;      ///< no inertia couples joints: every problem is one of free bodies
  bool frictional = false;       ///< some problem has friction rows
  bool all_solvable = false;     ///< every problem is proven solvable, or some answer passes
  bool ill_conditioned = false;  ///< by its name: exp5-*, exp6-* or *extra100*
  std::int64_t nearly = 0;             ///< problems of Truth::kNearly
  /// Every answer to any of these violates some contact by at least this. NaN: there are none; 0: no bound is known.
  double least_violation_m_per_s = kNoNumber;
  std::int64_t smallest_n = 0;         ///< order of M
  std::int64_t largest_n = 0;
};

/// The seed and the trial of a problem of a set.
struct ProblemKey {
  std::uint64_t seed = 0;
  std::int64_t trial = 0;
};

/// A distinct answer to a problem of a set. Packed: a set may have millions.
struct Outcome {
  double error = kNoNumber;  ///< the verdict's measure: rho, or the backward error of a bare LCP; NaN: none known
  double violation_m_per_s = kNoNumber;
  double solver_error_m_per_s = kNoNumber;  ///< residual of the conditions that the solver solves
  double model_error_m_per_s = kNoNumber;   ///< residual of the round cone's conditions; NaN without friction
  double time_s = kNoNumber;  ///< set-up and solve, CPU; NaN where nothing was timed
  std::uint32_t problem = 0;  ///< index among the problems of the set
  std::uint32_t group = 0;    ///< of the parameterisations that gave it: index in AnswerScan::groups()
  std::int32_t pivots = -1;
  Claim claim : 8 = Claim::kNumericalFailure;
  Verdict verdict : 8 = Verdict::kOpen;
  Truth truth : 8 = Truth::kUnknown;
  bool criterion : 1 = false;
  bool odd_trial : 1 = false;

  bool claimed() const { return claim == Claim::kSolved; }
  bool refused() const { return claim == Claim::kUnsupported; }  ///< outside what the solver takes
  bool solved() const { return verdict == Verdict::kSolved; }
  bool false_claim() const { return verdict == Verdict::kWrong; }
  /// The problem is proven to have no solution; where it has nearly one, the solver said so.
  bool unsolvable() const { return truth == Truth::kUnsolvable || verdict == Verdict::kUnsolvable; }
  /// What the paper counts as solved.
  bool passes_criterion() const { return claimed() && criterion; }
};

/// The parts of the time that an answer and its evaluation took [s]: transport is wall clock, verify CPU time.
inline constexpr std::array kTimeParts{"setup_wall", "setup_cpu", "solve_wall", "solve_cpu", "transport", "verify"};
using TimeParts = std::array<double, kTimeParts.size()>;

/// Counts and spreads of a cell's trials: of all, or of the even or odd ones alone. The best parameterisation of a
/// sweep is chosen on one half of the trials and reported on the other.
struct Part {
  std::int64_t trials = 0;
  std::int64_t solved = 0;  ///< verdict solved
  /// Left out of the rate: those proven to have no solution, whatever the solver made of them; of those that have
  /// nearly one, those where it said unsolvable.
  std::int64_t unsolvable_problems = 0;
  std::int64_t criterion = 0;      ///< claimed solved, and passes the paper's criterion
  std::int64_t criterion_any = 0;  ///< passes the paper's criterion, whatever was claimed

  Spread solved_time{};              ///< [s] of the trials with verdict solved
  Spread all_time{};                 ///< [s] of all timed trials but the refused ones
  Spread violation{};                ///< [m/s] of the trials with verdict solved
  Spread criterion_time{};           ///< [s] of the trials that count in `criterion`: the paper's "solved"
  Spread criterion_violation{};      ///< [m/s] of the same
  Spread criterion_any_time{};       ///< [s] of the trials that count in `criterion_any`
  Spread criterion_any_violation{};  ///< [m/s] of the same

  std::int64_t solvable() const { return trials - unsolvable_problems; }
  /// solved / solvable(); NaN when every problem is unsolvable.
  double rate() const;
  /// criterion / trials: the paper's solution frequency.
  double criterion_rate() const;
};

/// One solver parameterisation on one set. The verdicts are a partition of the trials:
/// solved + wrong + unsolvable + refused + missed + open = trials. Every other count overlaps with them.
struct Cell : Part {
  std::size_t set = 0;     ///< index into Summary::sets
  std::size_t solver = 0;  ///< index into Summary::solvers
  std::array<std::array<std::int64_t, kVerdicts>, kClaims> counts{};  ///< [claim][verdict]
  std::int64_t solved_1e6 = 0;                                        ///< verdict solved, and error <= 1e-6
  std::int64_t solved_1e9 = 0;                                        ///< verdict solved, and error <= 1e-9
  std::int64_t nearly_problems = 0;      ///< of truth nearly
  std::int64_t nearly_solved = 0;        ///< of these, with verdict solved
  std::int64_t nearly_unsolvable = 0;    ///< of these, with verdict unsolvable
  std::int64_t false_unsolvable = 0;     ///< claimed unsolvable, and the problem is proven solvable
  std::string refusal;                   ///< the most frequent reason among the refused problems, "" for none

  Interval rate_interval{};  ///< Wilson 95 %
  Estimate median_time{};    ///< [s] of the trials of all_time, 95 %; no interval for parameterisations of a sweep
  TimeParts time_parts{};            ///< means over the trials of all_time
  std::int64_t paired = 0;           ///< timed problems that both this solver and the reference solved
  Estimate time_ratio{};             ///< time / reference's time on those: ratio of sums, 95 %
  Spread solver_error{};  ///< [m/s] Outcome's, of the trials with verdict solved and a model error that is known
  Spread model_error{};   ///< [m/s] Outcome's, of the same
  Spread pivots{};                   ///< of all trials whose solver counts them
  const char* error_measure = "";    ///< "velocity_residual_relative", "backward_row_norm", "" when the set mixes kinds
  std::int64_t error_count = 0;      ///< answers claimed solved, whose errors follow, NaN as infinity; 0 if mixed
  double error_median = 0;
  double error_p99 = 0;
  double error_max = 0;

  std::array<Part, 2> halves{};  ///< even and odd trials

  std::vector<Outcome> outcomes;  ///< by problem; empty for parameterisations of a sweep

  std::int64_t count(Verdict verdict) const;
  std::int64_t count(Claim claim) const;
  std::int64_t count(Claim claim, Verdict verdict) const;
  std::int64_t false_claims() const { return count(Verdict::kWrong); }
  /// Verdict refused, missed or open: not solved, no false claim of solved, and not proven unsolvable. Includes claims
  /// of unsolvable without a valid proof, and answers claimed solved that Errors::unresolved leaves open.
  std::int64_t gave_up() const;
  /// Every problem was refused as outside what the solver takes.
  bool refused() const { return trials > 0 && count(Claim::kUnsupported) == trials; }
};

/// All that the report says, in numbers.
struct Summary {
  std::vector<RunSummary> runs;
  std::vector<SetSummary> sets;    ///< natural order of names: exp5-1e5 before exp5-1e10
  std::vector<SolverRow> solvers;  ///< natural order of specs
  std::vector<Cell> cells;         ///< by set, then solver
  std::string reference;  ///< spec that time ratios refer to; "" when the store has none
  /// Name and version of the one engine whose own answers the solver `engine` stands for; "" for several, or none.
  std::string engine;
  Coverage coverage;      ///< of what the runs planned
  std::int64_t differing = 0;  ///< captured problems that differ from the steps that their engines took
  std::map<std::string, std::int64_t> differences;  ///< in what, and how many of it in all these problems
};

/// Called with the problems of a set and its complete cells, which have their outcomes only during the call.
using SetVisitor = std::function<void(const Summary&, std::span<const ProblemKey>, std::span<const Cell>)>;

/// Reads a store, which may be half filled. The verdicts are those of AnswerScan; nothing is solved or verified again.
/// Byte for byte the same for equal rows.
/// @param visit  called for each set in turn
/// @throws InputError when the store cannot be read.
Summary summarize(Store& store, const SetVisitor& visit = nullptr);

/// summary.json, whose keys docs/howto/report.md explains; NaN and infinity are null. The parameterisations of a sweep,
/// which may be thousands, lack some keys, such as `claims` and the parts of the time. `sweeps` has the worst, average
/// and best rate over the parameterisations of each sweep on each set. `best_held_out` is the rate on the odd trials of
/// the parameterisation that is best on the even ones.
nlohmann::ordered_json summary_json(const Summary& summary);

}  // namespace lcpbench
