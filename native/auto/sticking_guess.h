#pragma once

#include "native/auto/island_task.h"
#include "native/auto/report.h"

namespace lcpbench {

/// When to guess that the contacts which stuck in the last answer stick again (see StickingContacts). After k wrong
/// guesses in a row that no method was loaded for, k steps make none.
class StickingGuess {
 public:
  explicit StickingGuess(IslandTask& task) : task_(task) {}

  /// The next problem. @param is_next_step of the last one @param rested the last one's answer
  void load(bool is_next_step, bool rested);
  void set_velocity() { pauses_ = false; }
  /// The next solve guesses before a method is loaded.
  bool waits() const { return waits_; }
  void stop_waiting() { waits_ = false; }

  /// Whether the last answer is one to guess from.
  bool is_worth_it(const Vector& start) const;
  /// Whether a guess was right: answer is then kSolved.
  bool solve(const Vector& start, Answer& answer, AutoReport& report);
  /// What came of the last solve().
  void note(bool was_right);

 private:
  IslandTask& task_;
  bool waits_ = false;
  bool pauses_ = false;  ///< no guess is made, after wrong ones
  int wrong_guesses_ = 0, steps_without_guess_ = 0;
};

}  // namespace lcpbench
