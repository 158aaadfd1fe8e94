#pragma once

#include <memory>

#include "native/auto/island_task.h"
#include "native/auto/report.h"
#include "native/auto/rest.h"

namespace lcpbench {

/// Where `auto` finds rest: whether hard contacts can hold an island at rest, and by which impulses.
///
/// An island may still rest with the last impulses; else they are found by a convex problem, before the methods where
/// that is likely to take less work, or after one of them has an answer that moves. LeastEnergy and the first convex
/// problem of friction_ipm solve the same problem. Impulses near rest are balanced to rounding, and the velocity is
/// then exactly zero.
class IslandRest {
 public:
  explicit IslandRest(IslandTask& task) : task_(task) {}

  void load();
  void set_velocity() { has_rest_ = false; }

  /// What comes first, at the velocity now: the methods, or the convex problem of rest by what takes less work.
  enum class First { kMethods, kActiveSets, kInteriorPoint };
  First first() const;

  void begin() { knows_no_rest_ = rests_ = false; }
  /// The answer of this solve is rest.
  bool rests() const { return rests_; }

  /// Whether the impulses of the last step hold the island at rest: as they are, or balanced anew if that may be tried.
  bool still_rests(const Vector& start, bool may_balance, Answer& answer, AutoReport& report);
  /// Whether the answer of contacts that stick again rests exactly, or does not nearly rest: from nothing it may.
  bool accepts(Answer& answer);
  /// Whether the impulses of least energy are an answer: they are unless a contact with friction presses and slips.
  bool find_by_active_sets(bool is_warm, Answer& answer, AutoReport& report);
  /// What an answer comes from. Impulses of an iterate may be far from those of rest, though its velocity is near.
  enum class From { kLeastEnergy, kMethod, kIterate };
  /// Puts rest in the place of the answer, where it is found.
  void improve(From from, Answer& answer, AutoReport& report);

 private:
  bool slips(const Answer& answer);
  bool is_refuted(const Answer& answer);
  void find_velocity(const Answer& answer);
  bool find(Answer& answer, AutoReport& report);
  bool find_by_interior_point(Answer& answer, AutoReport& report);
  bool is_refuted_near(const Vector& z);
  bool settle(Answer& answer, AutoReport& report);
  bool balance(double imbalance, Answer& answer, AutoReport& report, bool& may_be_imprecise);
  double work_of_active_sets() const;
  double work_of_interior_point() const;
  Rest& loaded_rest();

  IslandTask& task_;
  Rest rest_;
  bool has_rest_ = false;       ///< rest_ holds the problem
  bool knows_no_rest_ = false;  ///< in this solve the convex problem was solved, and contacts that press slip in it
  bool rests_ = false;
  std::unique_ptr<Answer> held_;  ///< scratch: an answer that may be one of rest
  Vector u_;                      ///< scratch: the velocity of an answer
  bool has_u_ = false;
};

}  // namespace lcpbench
