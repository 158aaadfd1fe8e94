#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "study/summary/summary.h"
#include "study/statistics/pairs.h"

namespace lcpbench {

/// Shift of every shifted geometric mean of times [s]: one period of a 1 kHz control loop. Solves far below it count by
/// their sum, as they do for a loop that has time for many; solves far above it by their ratio, so that a few slow ones
/// do not drown all others.
inline constexpr double kTimeShift = 1e-3;

/// Below this corrected p-value two solvers are said to differ.
inline constexpr double kSignificance = 0.05;

/// Factors of a performance profile: at 1 the share of problems on which a solver is the faster of the two.
inline constexpr std::array<double, 13> kProfileFactors{1, 1.05, 1.1, 1.25, 1.5, 2, 3, 5, 10, 20, 50, 100, 1000};

/// Two solvers on the problems of a set that both took. Solvers are indices into Summary::solvers here and below.
struct ComparedPair {
  std::size_t first = 0;
  std::size_t second = 0;
  PairedCounts solved;  ///< refused problems are left out; unsolvable ones are among those that neither solved
  double p = 1;         ///< exact McNemar
  double p_holm = 1;    ///< corrected over all pairs of the set

  /// The solver that solves more, if the corrected test tells them apart.
  std::optional<std::size_t> better() const;
};

/// How long one solver takes on a set, in three ways of weighing slow and failed solves.
struct SolverTimes {
  std::size_t solver = 0;
  std::int64_t problems = 0;  ///< not proven unsolvable; refused ones among them
  std::int64_t solved = 0;
  std::int64_t timed = 0;     ///< problems that the median and the geometric mean are over: all that it took
  Estimate median{};          ///< [s]
  Estimate geometric_mean{};  ///< [s], shifted by kTimeShift
  double par10 = 0;           ///< [s] over `problems`; NaN where failures meet no recorded time limit
};

/// Shares of the problems not proven unsolvable that a solver solved within a time, and answered within an error
/// whatever it claimed. What it failed on is in the whole: the curves end at its share solved, or wherever its answers
/// end.
struct Distribution {
  std::size_t solver = 0;
  std::int64_t problems = 0;
  std::vector<double> times_s;  ///< of the solved ones
  std::vector<double> errors;   ///< NaN: an answer without error, or none

  /// Shares at some targets. NaN without problems.
  std::vector<double> solved_within(std::span<const double> targets_s) const;
  std::vector<double> answered_within(std::span<const double> targets) const;
};

/// Dolan and More's performance profile (2002) of two solvers alone, as profiles of more rank differently when one of
/// them is left out (Gould and Scott 2016).
struct PairProfile {
  std::size_t solver = 0;
  std::size_t against = 0;
  std::int64_t problems = 0;  ///< that both took, not proven unsolvable, and timed where solved
  std::array<double, kProfileFactors.size()> solver_shares{};  ///< solved within a factor of the faster of the two
  std::array<double, kProfileFactors.size()> against_shares{};
};

/// What one solver adds to a portfolio.
struct Contribution {
  std::size_t solver = 0;
  std::int64_t solved = 0;
  std::int64_t alone = 0;    ///< solved by no other
  std::int64_t fastest = 0;  ///< solved it in the least time; on equal times the first in the store's order
};

/// One solver of a fallback chain.
struct ChainStep {
  std::size_t solver = 0;
  std::int64_t reached = 0;  ///< problems that no earlier step solved
  std::int64_t solved = 0;   ///< of these
};

/// Solvers to be tried one after the other until an answer passes verification. It relies on every answer being
/// verified: what a solver claims ends nothing. So a false claim costs time, and never a wrong answer.
struct FallbackChain {
  std::vector<ChainStep> steps;
  std::int64_t timed = 0;          ///< problems that the two means are over: those whose times are all known
  double mean_time_s = 0;          ///< of all solvers tried, per problem
  double mean_verification_s = 0;  ///< of all answers tried, as verified here
};

/// The best solver for each problem, known only afterwards: what no choice of one solver can beat.
struct VirtualBest {
  bool common_only = false;           ///< over the problems that all solvers met; else over all problems of the set
  std::vector<std::size_t> left_out;  ///< solvers that did not meet all of these problems
  std::int64_t problems = 0;          ///< not proven unsolvable
  std::int64_t solved = 0;            ///< by any
  Estimate median_time{};             ///< [s] of the fastest that solved each
  double mean_time_s = 0;             ///< of the same
  std::vector<Contribution> contributions;
  /// The shortest chain that solves as much: no chain with fewer solvers does (all subsets are tried), and among those
  /// of its length none has a smaller mean of time and verification. nullopt when nothing was solved, or when more than
  /// 2^20 subsets would have to be tried (possible with more than 20 solvers).
  std::optional<FallbackChain> chain;
};

/// All comparisons between the solvers of one set. Parameterisations of sweeps take no part: the summary keeps no
/// single outcomes of them.
struct SetComparison {
  std::size_t set = 0;
  std::vector<ComparedPair> pairs;
  std::vector<SolverTimes> times;
  std::vector<Distribution> distributions;
  std::vector<PairProfile> profiles;  ///< against the reference, then against the recommended solver
  std::vector<VirtualBest> virtual_bests;
};

/// Solver recommended for each set (index into Summary::sets), where one is.
using Recommendations = std::map<std::size_t, std::size_t>;

/// Compares the solvers of every set on the same problems. O(pairs x problems), and subsets for the chains.
std::vector<SetComparison> compare_solvers(const Summary& summary, const Recommendations& recommended = {});

/// The longest limit on one solve that the store's runs record [s]; NaN where none does.
double recorded_time_limit(const Summary& summary);

/// Does the solver replace the pyramid of some problems of the set by another friction model?
bool solves_other_model(const SetSummary& set, const SolverRow& solver);

/// SolverRow::text(), with level and version behind it where another solver of the summary, not in a sweep, has the
/// same.
std::string solver_label(const Summary& summary, std::size_t solver);

}  // namespace lcpbench
