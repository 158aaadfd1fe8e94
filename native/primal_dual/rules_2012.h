#pragma once

#include <functional>

#include "core/solver.h"
#include "core/types.h"

namespace lcpbench {

/// What counts of the settings of primal_dual.
struct Rules2012Settings {
  double gap_tolerance = 0;
  double residual_tolerance = 0;
  std::int64_t max_iterations = 0;
};

/// How a run of an interior-point method ends. kAccepted: by the early exit of 2012.
enum class InteriorEnd { kAccepted, kConverged, kStalled, kBreakdown, kIterationLimit, kTimeLimit };

/// What an answer claims and says of such an end.
Claim claim_of(InteriorEnd end);
const char* words_of(InteriorEnd end);

/// minimize 1/2 x'P x + p'x subject to A x + c >= 0, from a strictly feasible x, by the primal-dual interior-point
/// method without slacks, so that every iterate is strictly feasible. [Boyd, Vandenberghe 2004, section 11.7]
class FeasibleProgram {
 public:
  Matrix P, A;
  Vector p, c;

  /// Makes room for P (n x n), A (m x n) and all else.
  void resize(Index n, Index m);

  /// Moves x. @param accepts  asked of each iterate, the first included: true ends the run with kAccepted
  InteriorEnd minimize(const Rules2012Settings& settings, double deadline_s,
                       const std::function<bool(const Vector&)>& accepts, Vector& x, Counters& counters);

 private:
  void evaluate(const Vector& x, const Vector& lambda, double t);
  double residual_norm() const;
  bool find_direction(Counters& counters);
  bool line_search(double t, Vector& x);

  Vector slack_, lambda_;   // m: A x + c, and its multipliers
  Vector r_dual_, r_cent_;  // n, m
  Vector dx_, dlambda_, trial_x_, trial_lambda_, weight_;
  Matrix newton_, factor_;
};

/// Solves LCP(q, M) by the rules of the public code of 2012: see docs/reference/solvers/primal_dual.md.
class PrimalDual2012 {
 public:
  void load(const Lcp& lcp);
  /// Sets z, claim, detail and counters.
  void solve(const Rules2012Settings& settings, double deadline_s, Answer& answer);

 private:
  InteriorEnd find_start(const Rules2012Settings& settings, double deadline_s, Counters& counters);
  bool accepts(const Vector& z);

  Lcp lcp_;
  FeasibleProgram phase_1_, program_;
  Vector start_;  // n + 1: z and the largest violation
  Vector w_, best_;
  double best_product_ = 0;
};

}  // namespace lcpbench
