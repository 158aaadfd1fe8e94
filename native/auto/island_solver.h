#pragma once

#include <memory>

#include "native/auto/island_rest.h"
#include "native/auto/island_task.h"
#include "native/auto/report.h"
#include "native/auto/sticking_guess.h"

namespace lcpbench {

/// Solves one contact problem: from a last answer by the guess that its impulses hold again, or that the contacts that
/// stuck in it stick again; else by methods that take turns, in the order of Order, and by the convex problem of rest
/// (IslandRest), before them or after one has an answer. A method that claims kUnsolvable has a proof; so has
/// AnswerTest, which is asked once no method has an answer after the first round.
///
/// If hard contacts can hold the island at rest, and G is given, the answer is rest, and its velocity exactly zero.
///
/// load() loads the first method, unless that takes long; all others are loaded when their turn comes, which allocates.
class IslandSolver {
 public:
  /// @param shared methods that other islands use as well
  /// @param is_whole each problem is one island with all its contacts and coordinates, and the next step of the last
  IslandSolver(Methods& shared, const std::shared_ptr<LaterEngines>& later, double error, bool is_whole);

  /// Of the problems loaded from now on: how many coordinates no contact moves. At first none.
  void expect_idle(Index coordinates) { task_.idle = coordinates; }

  /// How the methods are loaded. At first: the first one at once.
  struct Load {
    bool in_turn = false;      ///< when solve() needs them, into the shared ones: small islands touch memory once
    bool after_guess = false;  ///< the next step: only if solve() finds that the contacts of the last one do not hold
  };
  /// @param problem must outlive the next load @param v the velocity now
  void load(const Problem& problem, const Vector& v, const Load& how);
  /// Another velocity.
  void update(const Vector& v);

  /// `answer` as of Solver::solve(). Where the claim is neither solved nor unsolvable z is the best iterate.
  void solve(const Vector* start, const AutoLimits& limits, Answer& answer, AutoReport& report);

  /// Work that the first method takes on about half of all islands of this size, or of that of the last step.
  double likely_work() const { return task_.order.likely_work(); }
  /// The velocity of an answer that came without.
  void respond(const Answer& answer, Vector& u) { task_.methods->respond(task_.answered_by, answer.z, u); }

 private:
  void choose();
  void load_first();
  bool take_turns(const Vector* start, Answer& answer, AutoReport& report);
  bool is_too_late_for(AutoMethod method, double deadline_s);
  double note_iterate(BudgetedSolver& solver, AutoMethod method, const Answer& answer);
  void take_best(Claim otherwise, Answer& answer);

  const double error_;
  Methods own_;
  Methods& shared_;
  IslandTask task_;
  StickingGuess guess_{task_};
  IslandRest rest_{task_};
  IslandRest::First first_ = IslandRest::First::kMethods;
  Vector best_;               ///< the best iterate of this solve
  double best_residual_ = 0;  ///< infinity: there is none
  bool is_iterate_ = false;   ///< the answer is one of a method that has not ended, and no error is stated
};

}  // namespace lcpbench
