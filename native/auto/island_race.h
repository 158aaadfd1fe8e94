#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>

#include "native/answer_test/answer_test.h"
#include "native/auto/features.h"
#include "native/auto/methods.h"
#include "native/auto/race.h"
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
/// stuck in it stick again; else by a race of methods, and by the convex problem of rest, before the race or after it.
///
/// If hard contacts can hold the island at rest, and G is given, the answer is rest, and its velocity exactly zero.
///
/// load() loads the method that is predicted to be the fastest, unless that takes long; all others are loaded when
/// their turn comes, which allocates.
class IslandRace final : private Stable {
 public:
  /// @param shared methods that other islands use as well
  /// @param is_whole each problem is one island with all its contacts and coordinates, and the next step of the last
  IslandRace(Methods& shared, const std::shared_ptr<LaterEngines>& later, double error, bool is_whole);

  /// Of the problems loaded from now on: how many coordinates no contact moves. At first none.
  void expect_idle(Index coordinates) { idle_ = coordinates; }

  /// How the methods are loaded. At first: the fastest one at once.
  struct Load {
    bool in_turn = false;      ///< when solve() needs them, into the shared ones: small islands touch memory once
    bool after_guess = false;  ///< only if solve() finds that the contacts of the last step do not hold
  };
  /// @param problem must outlive the next load @param v the velocity now
  void load(const Problem& problem, const Vector& v, const Load& how);
  /// Another velocity.
  void update(const Vector& v);

  /// `answer` as of Solver::solve(). Where the claim is neither solved nor unsolvable z is the best iterate.
  void solve(const Vector* start, const AutoLimits& limits, Answer& answer, AutoReport& report);

  /// Work that the fastest method is predicted to take.
  double predicted();
  /// The velocity of an answer that came without.
  void respond(const Answer& answer, Vector& u) { methods_->respond(answered_by_, answer.z, u); }

 private:
  /// What comes first: the race, or the convex problem of rest by what takes less work.
  enum class Order { kRaceFirst, kActiveSetsFirst, kInteriorPointFirst };

  Entrant first() override { return first_; }
  std::span<const Entrant> entrants() override;
  ResumableSolver& loaded(std::size_t entrant) override { return methods_->loaded(order_[entrant]); }
  bool passes(const Vector& best, Answer& answer) override;
  bool disproves(Answer& answer) override;
  void enter();
  void choose();
  void expect_rest();
  void load_first();
  std::size_t entrant_of(AutoMethod method) const;
  double aim_of(double error) const;
  double largest_claimed() const;
  double work_before_proof();
  AnswerTest& loaded_test();
  Order order();
  double cost_of_active_sets() const;
  double cost_of_interior_point();
  Rest& loaded_rest();
  StickingContacts& loaded_sticking();
  bool still_rests(const Vector& start, Answer& answer, AutoReport& report);
  bool guesses(const Vector* start) const;
  bool sticks_again(const Vector& start, const AutoLimits& limits, Answer& answer, AutoReport& report);
  bool race(const Vector* start, const AutoLimits& limits, Answer& answer, AutoReport& report);
  bool rests(bool is_warm, const AutoLimits& limits, Answer& answer, AutoReport& report);
  bool rests_by_interior_point(const AutoLimits& limits, Answer& answer, AutoReport& report);
  bool is_refuted_by(ResumableSolver& method, Answer& scratch);
  bool slips(const Answer& answer);
  void find_velocity(const Answer& answer);
  bool may_rest_instead(const Answer& answer);
  bool find_rest(const AutoLimits& limits, Answer& answer, AutoReport& report);
  bool balance(double imbalance, Answer& answer, AutoReport& report);
  bool settle_at_rest(Answer& answer, AutoReport& report);
  void take_best(Race::End end, Answer& answer);

  const double error_;
  const bool is_whole_;
  Methods own_;
  Methods& shared_;
  Methods* methods_;
  Index idle_ = 0;
  const Problem* problem_ = nullptr;
  Vector v_;
  Features features_;
  std::array<AutoMethod, Race::kMostEntrants> order_{};
  Entrant first_;
  std::array<Entrant, Race::kMostEntrants> entrants_{};
  std::size_t count_ = 0;         ///< of entrants
  bool has_predictions_ = false;  ///< of entrants_
  Order order_of_rest_ = Order::kRaceFirst;
  bool knows_no_rest_ = false;  ///< in this solve the convex problem was solved, and contacts that press slip in it
  Rest rest_;
  bool has_rest_ = false;  ///< rest_ holds the problem
  Race race_;
  bool is_unsettled_ = false;  ///< the last answer: it may be near one of rest
  bool has_raced_ = false;     ///< in this solve
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
