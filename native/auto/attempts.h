#pragma once

#include <array>
#include <memory>

#include "core/problem.h"
#include "native/auto/held_contacts.h"
#include "native/auto/least_energy.h"
#include "native/auto/methods.h"
#include "native/auto/plan.h"
#include "native/auto/settings.h"

namespace lcpbench {

/// One solver of each method, with the memory of the largest problem so far, most of which is never touched. Islands
/// use these solvers in turn if their first method gives up.
class SharedMethods {
 public:
  SharedMethods();

  Solver& of(AutoMethod method);
  /// Forgets what the solvers hold: another problem is to be solved.
  void begin_solve() { holds_.fill(false); }
  /// The same solver, with this problem at this velocity. Loads it where that was not done since begin_solve().
  Solver& holding(AutoMethod method, const Problem& problem, const Vector& v);
  /// Takes the memory for load() of a dense method. @pre fits_in_advance(method, problem)
  void reserve(AutoMethod method, const Problem& problem);
  /// What the rungs of contact_lemke beyond double run on, for all islands: they take turns.
  const std::shared_ptr<LaterEngines>& later_engines() const { return later_; }
  LeastEnergy& least_energy() { return least_energy_; }

 private:
  std::shared_ptr<LaterEngines> later_;
  std::array<std::unique_ptr<Solver>, kAutoMethods> solvers_;
  std::array<bool, kAutoMethods> holds_{};
  LeastEnergy least_energy_;
};

/// A contact problem with its plan: tries one method after the other until one does not give up.
///
/// The first method is loaded by load(), or in turn with other islands in solve(). Dense ones that follow are loaded in
/// solve(), with memory that was taken before; any other that follows is loaded in the first solve() that needs it,
/// which allocates.
class Attempts {
 public:
  /// What is known of all problems: nothing; with friction they are one island with all their contacts and coordinates;
  /// they always are, and each is the next step of the last.
  enum class Scope { kParts, kIsland, kWhole };

  Attempts(const AutoSettings& settings, SharedMethods& shared, Scope scope = Scope::kParts)
      : settings_(settings), shared_(shared), scope_(scope) {}

  /// Of the problems loaded from now on: how many coordinates no contact moves. At first none.
  void expect_idle(Index coordinates) { idle_ = coordinates; }

  /// @param problem must outlive the next load @param v the velocity now
  /// @param in_turn a dense first method is not loaded: until the next update() the shared one solves, which touches
  ///     memory once for all islands, and forgets the island
  void load(const Problem& problem, const Vector& v, bool in_turn = false);
  /// The same after a step with nearly these contacts: where friction may hold them nothing is loaded before a solve()
  /// whose guess that they hold is wrong, or that has no start to make it from. After guesses on a small island that
  /// were wrong as many steps follow without one.
  void load_to_hold(const Problem& problem, const Vector& v, bool in_turn = false);
  /// Does not load the sparse first method. update() loads it. A solve() before that uses the dense methods.
  /// @returns false where there is no other, and nothing was put off
  bool load_when_needed(const Problem& problem, const Vector& v);

  /// True if a solve before the next update() uses another method in place of velocity_ipm. That method may take a
  /// hundred times as long.
  bool has_stand_in() const {
    return plan_.front().method == AutoMethod::kVelocityIpm || sweeps_ > 0;
  }

  /// Another velocity. Loads the first method if it was put off, or if the new velocity changes the plan.
  void update(const Vector& v);
  /// The same, but what was put off stays so, and the plan too. Allocates nothing.
  void set_velocity(const Vector& v);

  /// @param request its time limit is not used: limits has it
  void solve(const SolveRequest& request, const AutoLimits& limits, Answer& answer, AutoReport& report);

  /// The velocity of an answer that came without. O(ngc^2), after psor O(nonzeros)
  void respond(const Answer& answer, Vector& u);

 private:
  void begin(const Problem& problem, const Vector& v);
  void load_methods(bool in_turn);
  bool is_loaded(AutoMethod method) const { return loaded_[static_cast<std::size_t>(method)]; }
  Solver& own(AutoMethod method) { return *own_[static_cast<std::size_t>(method)]; }
  void load_own(AutoMethod method);
  void reserve_what_follows();
  bool is_left_out(const AutoTry& now) const;
  Solver& ready(AutoMethod method);
  bool may_have_missed_rest(const Answer& answer) const;
  bool tried(const AutoTry& now, const SolveRequest& request, bool is_last, const AutoLimits& limits, Answer& answer,
             AutoReport& report);
  LeastEnergy& least_energy();
  void load_least_energy();
  bool may_hold(const SolveRequest& request) const;
  bool holds(const SolveRequest& request, const AutoLimits& limits, Answer& answer, AutoReport& report);
  bool rests(const SolveRequest& request, const AutoLimits& limits, Answer& answer, AutoReport& report);

  const AutoSettings& settings_;
  SharedMethods& shared_;
  Scope scope_ = Scope::kParts;
  Index idle_ = 0;
  const Problem* problem_ = nullptr;
  Vector v_;
  AutoPlan plan_;
  std::int64_t sweeps_ = 0;  ///< worthwhile_sweeps
  std::array<std::unique_ptr<Solver>, kAutoMethods> own_;
  std::array<bool, kAutoMethods> loaded_{};  ///< whether the own solver holds the problem
  std::unique_ptr<LeastEnergy> least_energy_;
  bool has_least_energy_ = false;  ///< least_energy_ holds the problem
  std::unique_ptr<HeldContacts> held_;
  bool has_held_ = false;           ///< held_ holds the problem
  bool friction_may_hold_ = false;  ///< see friction_may_hold(), of a loaded first method
  bool waits_ = false;              ///< of load_to_hold(): no method is loaded, there is no plan
  bool in_turn_ = false;            ///< of load_to_hold()
  int wrong_guesses_ = 0;           ///< of steps for which load_to_hold() waited, the last ones in a row
  int steps_without_guess_ = 0;     ///< that follow them, as many as they were
  bool takes_turns_ = false;        ///< the shared solvers stand for the own ones
  bool is_put_off_ = false;
  Solver* answered_ = nullptr;  ///< what gave the last answer
  AutoMethod answered_by_ = AutoMethod::kActiveSet;
};

}  // namespace lcpbench
