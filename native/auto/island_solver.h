#pragma once

#include <array>
#include <cstddef>
#include <memory>

#include "native/answer_test/answer_test.h"
#include "native/auto/methods.h"
#include "native/auto/order.h"
#include "native/auto/report.h"
#include "native/auto/rest.h"
#include "native/auto/sticking_contacts.h"

namespace lcpbench {

/// Of one solve.
struct AutoLimits {
  double deadline_s = 0;  ///< on wall_clock_s(); infinity: none
  double error = 0;       ///< that the answer may leave; 0: none is stated
};

/// Solves one contact problem: from a last answer by the guess that its impulses hold again, or that the contacts that
/// stuck in it stick again; else by methods that take turns (see Order), and by the convex problem of rest, before them
/// or after one has an answer.
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
  void expect_idle(Index coordinates) { idle_ = coordinates; }

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
  double likely_work() const { return order_.likely_work(); }
  /// The velocity of an answer that came without.
  void respond(const Answer& answer, Vector& u) { methods_->respond(answered_by_, answer.z, u); }

 private:
  enum class Progress { kNone, kBegun, kEnded };
  /// What comes first: the methods, or the convex problem of rest by what takes less work.
  enum class Rests { kAfterwards, kByActiveSets, kByInteriorPoint };

  bool passes(const Vector& z, Answer& answer);
  bool disproves(Answer& answer);
  void choose();
  void load_first();
  bool is_too_late_for(AutoMethod method, double deadline_s);
  double aim_of(double error) const;
  double largest_claimed() const;
  AnswerTest& loaded_test();
  Rests when_to_rest() const;
  double work_of_active_sets() const;
  double work_of_interior_point() const;
  Rest& loaded_rest();
  StickingContacts& loaded_sticking();
  bool still_rests(const Vector& start, Answer& answer, AutoReport& report);
  bool guesses(const Vector* start) const;
  bool sticks_again(const Vector& start, const AutoLimits& limits, Answer& answer, AutoReport& report);
  bool take_turns(const Vector* start, const AutoLimits& limits, Answer& answer, AutoReport& report);
  double note_iterate(BudgetedSolver& solver, AutoMethod method, const Answer& answer);
  bool rests(bool is_warm, const AutoLimits& limits, Answer& answer, AutoReport& report);
  bool rests_by_interior_point(const AutoLimits& limits, Answer& answer, AutoReport& report);
  bool is_refuted_near(const Vector& z);
  bool slips(const Answer& answer);
  void find_velocity(const Answer& answer);
  bool may_rest_instead(const Answer& answer);
  bool find_rest(const AutoLimits& limits, Answer& answer, AutoReport& report);
  bool balance(double imbalance, Answer& answer, AutoReport& report);
  bool settle_at_rest(Answer& answer, AutoReport& report);
  void take_best(Claim otherwise, Answer& answer);

  const double error_;
  const bool is_whole_;
  Methods own_;
  Methods& shared_;
  Methods* methods_;
  Index idle_ = 0;
  const Problem* problem_ = nullptr;
  Vector v_;
  Order order_;
  Rests rests_ = Rests::kAfterwards;
  bool knows_no_rest_ = false;  ///< in this solve the convex problem was solved, and contacts that press slip in it
  Rest rest_;
  bool has_rest_ = false;  ///< rest_ holds the problem
  bool is_unsettled_ = false;  ///< the last answer: it may be near one of rest
  std::array<Progress, kAutoMethods> progress_{};  ///< in this solve
  Vector best_;               ///< the best iterate of this solve
  double best_residual_ = 0;                       ///< infinity: there is none
  bool is_rough_ = false;  ///< the answer is an iterate of a method that has not ended, with no error stated
  AnswerTest test_;            ///< of iterates
  bool has_test_ = false;      ///< it holds the problem
  AutoLimits limits_;
  std::unique_ptr<StickingContacts> sticking_;
  bool has_sticking_ = false;    ///< sticking_ holds the problem
  bool waits_ = false;           ///< for the guess: no method is loaded
  bool pauses_ = false;          ///< no guess is made, after wrong ones
  int wrong_guesses_ = 0;        ///< of steps that waited, the last ones in a row
  int steps_without_guess_ = 0;  ///< that follow them, as many as they were
  bool rested_ = false;          ///< in the last solve
  AutoMethod answered_by_ = AutoMethod::kFrictionIpm;
  std::unique_ptr<Answer> held_;  ///< scratch: an answer that may be one of rest
  Vector answered_u_;             ///< scratch: the velocity of an answer
  bool has_answered_u_ = false;
};

}  // namespace lcpbench
