#pragma once

#include <csignal>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "study/stability/transformations.h"
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
  int permutations = 5;                            ///< drawn for each problem; of every other kind one is drawn
  std::function<void(const std::string&)> on_set;  ///< called with each set's name before it is run
  /// Set to non-zero from outside (a signal handler): no problem is begun any more, and the result is of those before.
  const volatile std::sig_atomic_t* stop = nullptr;
};

/// One solver under one kind of transformation. The unit of every count is a problem, so that intervals of shares hold:
/// what happens in any of the draws for it counts once.
struct StabilityCell {
  TransformationKind kind = TransformationKind::kPermutation;
  std::size_t solver = 0;
  std::int64_t asked = 0;         ///< problems that the transformation applies to, taken by the solver before and after
  std::int64_t solved = 0;        ///< of these: the original's verdict is solved
  std::int64_t kept = 0;          ///< of these: solved after every draw too
  std::int64_t honest = 0;        ///< asked, and no false claim on the original
  std::int64_t turned_false = 0;  ///< of these: a false claim after some draw
  std::vector<std::string> examples;  ///< "SET trial T", the first few problems lost or turned false

  std::string farthest;  ///< "SET trial T" of the largest amplification

  // One entry for each problem solved before and after: the largest over its draws.
  std::vector<double> changes;         ///< of a unique answer, relative: see stability()
  std::vector<double> amplifications;  ///< that / (condition times the larger of eps and the change of the data)
  std::vector<double> distances;       ///< of velocities where they are not unique: largest |N'(v+ - u+)| / max|q|
  std::vector<double> residuals;       ///< relative velocity residual after (bare LCP: row-norm backward error)
  /// Most pivots over fewest, original and draws; only of solvers that count them.
  std::vector<double> pivot_spreads;

  static constexpr std::size_t kExamples = 3;

  std::int64_t lost() const { return solved - kept; }
  double largest_amplification() const;  ///< NaN without entries
  /// A solved problem is no longer solved, or an honest answer becomes a false claim.
  bool breaks() const { return lost() > 0 || turned_false > 0; }
  /// The answer moved more than conditioning allows. Not for NaN.
  bool moves_too_far() const { return largest_amplification() > kAllowedAmplification; }
};

struct StabilityResult {
  std::vector<std::string> sets;
  std::int64_t problems = 0;
  std::int64_t left_out = 0;  ///< too large
  std::vector<std::string> solvers;
  std::vector<StabilityCell> cells;  ///< by kind, then solver
};

/// Solves problems and their transformed copies, and compares the physical answers.
///
/// Each answer is judged on the problem that the solver was given, by the one evaluation. Transformations that perturb
/// the data are applied only if theory proves the problem solvable for all data nearby, so that a lost answer is always
/// the solver's fault. The answer of a frictionless problem with definite inertia is its velocity after the impact
/// (the one returned, else the one that follows from z), and its change is measured in the norm of G relative to v;
/// that of a bare LCP with definite M is z, in the largest norm relative to z. Conditioning allows the condition times
/// the larger of eps and the change of the data, at most 1: the condition of M as its data have it and of G, the
/// larger, or of M + M' of a bare LCP; each with unit diagonal, of the nonzero eigenvalues.
///
/// One thread; each problem with all of its copies for all solvers before the next.
StabilityResult stability(const std::vector<StudySet>& sets, const std::vector<StudySolver>& solvers,
                          const StabilityOptions& options);

}  // namespace lcpbench
