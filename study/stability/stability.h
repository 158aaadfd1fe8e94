#pragma once

#include <csignal>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "generators/changed.h"
#include "study/run/study.h"

namespace lcpbench {

/// A solver that does not lose more digits than the problem's conditioning takes stays below this amplification: the
/// constants of error bounds are a small multiple of the order, and orders here are 10 to 100.
inline constexpr double kAllowedAmplification = 1000;

/// Problems above this order are left out: their conditioning is not computed.
inline constexpr Index kLargestStabilityOrder = 600;

struct StabilityOptions {
  std::uint64_t seed = 1;
  double time_limit_s = 1.0;
  std::function<void(const std::string&)> on_set;  ///< called with each set's name before it is run
  /// Set to non-zero from outside (a signal handler): the work ends after the current solve, and the result is of the
  /// problems that were solved before with all their changes.
  const volatile std::sig_atomic_t* stop = nullptr;
};

/// One solver under one change. The unit of every count is a problem, so that intervals of shares hold: what happens in
/// any of the draws for it counts once.
struct StabilityCell {
  Change change = Change::kOrder;
  std::size_t solver = 0;
  std::int64_t asked = 0;         ///< problems that the change applies to, taken by the solver before and after
  std::int64_t solved = 0;        ///< of these: the original's verdict is solved
  std::int64_t kept = 0;          ///< of these: solved after every draw too
  std::int64_t honest = 0;        ///< asked, and no false claim on the original
  std::int64_t turned_false = 0;  ///< of these: a false claim after some draw
  std::vector<std::string> examples;   ///< "SET trial T", the first few problems lost or turned false
  std::string farthest;                ///< "SET trial T" of the largest amplification
  std::vector<double> amplifications;  ///< largest over the draws, of problems kept whose physical answer is unique

  static constexpr std::size_t kExamples = 3;

  std::int64_t lost() const { return solved - kept; }
  double largest_amplification() const;  ///< infinite where one is NaN; NaN without entries
  /// A solved problem is no longer solved, or an honest answer becomes a false claim.
  bool breaks() const { return lost() > 0 || turned_false > 0; }
  bool moves_too_far() const { return largest_amplification() > kAllowedAmplification; }
};

struct StabilityResult {
  std::vector<std::string> sets;
  std::int64_t problems = 0;
  std::int64_t left_out = 0;  ///< too large
  std::vector<std::string> solvers;
  std::vector<StabilityCell> cells;  ///< by change, then solver
};

/// Solves the problems of sets and those of changed{of=SET,by=...}, and compares the physical answers.
///
/// Each answer is judged on the problem that the solver was given, by the solver's model of friction. Changes of the
/// data are made only if theory proves the problem solvable for all data nearby, so that a lost answer is always the
/// solver's fault.
/// The amplification is the change of the answer over what conditioning allows: the condition times the larger of eps
/// and the change of the data, at most 1. It is measured where the answer is unique by theory: frictionless contacts
/// with definite inertia, and bare LCPs with definite M.
///
/// One thread; each problem with all of its changes for all solvers before the next.
StabilityResult stability(const std::vector<StudySet>& sets, const std::vector<StudySolver>& solvers,
                          const StabilityOptions& options);

}  // namespace lcpbench
