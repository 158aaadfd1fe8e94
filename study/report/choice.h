#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "study/statistics/statistics.h"

// Which solver to take for some sets of problems at some error: the one rule of the report, of its tables and of its
// page. It works on pooled statistics alone, so that the page, which has the same statistics, can answer for any
// selection of sets, solvers and error. src/choice.js of the page is the same rule; a test compares the two.

namespace lcpbench::report {

/// Errors that an answer may have to meet: rho of a contact problem, the backward error of a bare LCP. The first stands
/// for the threshold of the verdict.
inline constexpr std::array kErrorGrid{kNoNumber, 1e-1, 1e-2, 1e-3,  1e-4,  1e-5, 1e-6,
                                       1e-7,      1e-8, 1e-9, 1e-10, 1e-11, 1e-12};
inline constexpr std::size_t kErrors = kErrorGrid.size();

/// So many problems of a set at most, the first ones, stand in performance profiles.
inline constexpr std::size_t kProfiled = 200;

/// One solver at single settings on one set. Arrays are by kErrorGrid. A problem that is proven to have no solution
/// counts neither in `solved` nor in `gave_up`, and in every other count as any problem does.
struct CellStatistics {
  std::size_t set = 0;     ///< index into Summary::sets
  std::size_t solver = 0;  ///< index into Summary::solvers
  bool other_model = false;       ///< it solves another friction model than the set's pyramid
  std::int64_t met = 0;           ///< problems, the refused ones among them
  std::int64_t refused = 0;       ///< outside what the solver takes: neither failures nor successes
  std::int64_t unsolvable = 0;    ///< not refused, and proven to have no solution
  std::int64_t crashed = 0;
  std::int64_t gave_up = 0;       ///< verdict missed or open, crashes among them
  std::array<std::int64_t, kErrors> solved{};
  std::array<std::int64_t, kErrors> wrong{};  ///< said solved, and is neither solved nor within the error
  LogSums time;                   ///< set-up and solve, CPU, of all problems that it took
  double error_p99 = kNoNumber;   ///< of the answers said to be solved; NaN: there are none
  /// Of each of the first kProfiled problems of the set: 0 where it was not met, was refused, is proven to have no
  /// solution or has no time; else 32 t + 16 s + e. t is round(200 log10(time / 1 ns)) + 1, s is 1 if the answer is
  /// solved, and e says how many of kErrorGrid, without its first, the answer is within.
  std::vector<std::int32_t> profile;

  std::int64_t taken() const { return met - refused; }
};

/// Two solvers on the problems of a set that both took. Problems with nearly a solution that only one of them called
/// unsolvable are left out.
struct PairStatistics {
  struct AtError {
    std::int64_t only_a = 0;  ///< solved by a alone
    std::int64_t only_b = 0;
    std::int64_t wrong_a = 0;  ///< wrong claims of a alone
    std::int64_t wrong_b = 0;
    LogSums ratio;  ///< logarithms of time of b over time of a, on the problems that both solved
    bool operator==(const AtError&) const = default;
  };
  std::size_t set = 0;
  std::size_t a = 0;  ///< a < b
  std::size_t b = 0;
  std::int64_t both_took = 0;
  std::int64_t both_unsolvable = 0;  ///< of these, proven to have no solution
  std::array<AtError, kErrors> at{};
};

/// How many answers a set's plan asks for, and how many are there; zeros where nobody knows.
struct SetPlan {
  std::int64_t planned = 0;
  std::int64_t done = 0;
};

struct Statistics {
  std::vector<CellStatistics> cells;  ///< by set, then solver
  std::vector<PairStatistics> pairs;  ///< by set, then a, then b; without those that refused the whole set
  std::vector<SetPlan> plans;  ///< by set

  const CellStatistics* cell(std::size_t set, std::size_t solver) const;
  const PairStatistics* pair(std::size_t set, std::size_t a, std::size_t b) const;
};

/// A share of a count, with its Wilson interval.
struct Share {
  std::int64_t part = 0;
  std::int64_t whole = 0;

  double value() const;
  Interval interval() const { return wilson(part, whole); }
};

/// A reliable solver solves at least this share of the problems that it takes: the lower end of its 95 % interval does.
inline constexpr double kReliableShare = 0.9;
/// A solver that was caught with a false claim stays reliable only where the upper end of the 95 % interval of its
/// share of false claims is at most this.
inline constexpr double kFalseClaimBound = 0.01;
/// A solver that refuses more than this share of the problems does not take these problems.
inline constexpr double kRefusedBound = 0.1;
/// Before this share of a plan is done no solver is called reliable that took fewer than ample_problems(): the plan
/// said how many problems the paired test needs.
inline constexpr double kPlanShare = 0.5;
/// Below this p-value of the paired test two solvers are said to differ.
inline constexpr double kSignificance = 0.05;

/// The fewest problems that can show a share of kReliableShare: that many, all solved, have a lower end above it. A
/// factor between two solvers takes as many.
std::int64_t least_problems();
/// So many problems without a false claim bound their share by kFalseClaimBound.
std::int64_t ample_problems();
/// Whether so many problems, from such a share of the plan, are too few to call any solver reliable.
bool too_few(std::int64_t problems, double plan_share);

/// Why a solver has its standing. Reliable or unreliable come first: after kBehindTheBest nothing is said of that.
enum class Ground {
  kNone,           ///< reliable
  kFalseClaims,    ///< unreliable: false claims above the bound, or significantly more than the best
  kUnsolved,       ///< unreliable: the whole interval of its share solved is below kReliableShare
  kBehindTheBest,  ///< unreliable: solves significantly fewer than the best
  kFewProblems,    ///< too few: fewer than least_problems()
  kSmallSample,    ///< too few: less than half as many problems as another solver
  kShortOfPlan,    ///< too few: less than kPlanShare of the plan is done
  kWideInterval,   ///< too few: the interval of its share solved contains kReliableShare
  kOtherModel,     ///< partly: solves another friction model, and was judged by that
  kNoTime,         ///< partly: nobody measured its time
  kSomeSets,       ///< partly: took no problem of one of the sets
  kRefuses,        ///< partly: refused more than kRefusedBound
};

/// "reliable", "false_claims", "unsolved", "behind_the_best", "few_problems", "small_sample", "short_of_plan",
/// "wide_interval", "other_model", "no_time", "some_sets", "refuses".
const char* to_string(Ground ground);

/// The time of one solver over that of another, on the problems that both solved.
struct Factor {
  Estimate ratio{kNoNumber, kNoNumber, kNoNumber};  ///< geometric mean
  std::int64_t problems = 0;

  /// Fewer than least_problems() carry no factor.
  bool shown() const { return problems >= least_problems(); }
};

/// One solver on some sets at some error. Sets of which it took no problem do not count.
struct Contender {
  std::size_t solver = 0;
  Share solved;        ///< of the problems that it took and that are not proven unsolvable
  Share false_claims;  ///< of the problems that it took
  Share refused;       ///< of the problems that it met
  Estimate time{kNoNumber, kNoNumber, kNoNumber};  ///< [s] geometric mean over the problems that it took
  double error_p99 = kNoNumber;  ///< the largest of the sets': 99 % of the answers on each have at most this error
  bool other_model = false;
  bool met_all_sets = false;  ///< it took at least one problem of each
  Ground ground = Ground::kFewProblems;
  Factor factor;     ///< its time over the recommended solver's; without problems where none is
  bool tie = false;  ///< reliable, no refusal, no false claim, and `factor` is shown and cannot be told from 1

  bool reliable() const { return ground == Ground::kNone; }
  /// The share that it solves for sure of the problems that it met, a refused one as one that it does not solve: the
  /// lower end of the 95 % interval. NaN where all are proven unsolvable.
  double sure_share() const { return wilson(solved.part, solved.whole + refused.part).low; }
};

struct Choice {
  std::vector<Contender> contenders;  ///< the recommended one first, then by sure_share(), time and solver
  bool recommended = false;           ///< the first of them is
  double plan_share = 1;              ///< of the answers planned for these sets those that are there; 1: nobody knows
  std::int64_t most_solvable = 0;     ///< problems not proven unsolvable that any contender took
};

/// Judges the solvers on the problems of all the sets together, and recommends the fastest, by the geometric mean of
/// its times, among the reliable ones that refused none of the problems. What each must show is with `Ground`. Each is
/// compared to the best: the one with the highest lower end of the interval of its share solved, of those that took at
/// least half as many problems as any other and one of each set, solved one, solve the pyramid and have a time.
/// @param solvers  those that may be chosen; the others take no part
/// @param error    index into kErrorGrid
Choice choose(const Statistics& statistics, const std::vector<std::size_t>& sets,
              const std::vector<std::size_t>& solvers, std::size_t error);

}  // namespace lcpbench::report
