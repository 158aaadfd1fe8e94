#include "native/auto/sticking_guess.h"

namespace lcpbench {
namespace {

/// Guesses which contacts hold, on islands whose first method is loaded. On others those after the first hardly ever
/// find it.
constexpr int kTriesIfLoaded = 3;

}  // namespace

void StickingGuess::load(bool is_next_step, bool rested) {
  waits_ = is_next_step && (rested || StickingContacts::is_worth_a_guess(task_.contact(), false));
  pauses_ = is_next_step && steps_without_guess_ > 0;
  if (pauses_) --steps_without_guess_;
  waits_ = waits_ && !pauses_;
}

bool StickingGuess::is_worth_it(const Vector& start) const {
  return !pauses_ && StickingContacts::is_worth_a_guess(task_.contact(), !waits_) &&
         StickingContacts::sticking(task_.contact(), task_.v, start);
}

bool StickingGuess::solve(const Vector& start, Answer& answer, AutoReport& report) {
  Counters work{.iterations = 0, .pivots = 0, .factorizations = 0};
  const int tries = StickingContacts::is_worth_a_guess(task_.contact(), true) ? kTriesIfLoaded : 1;
  const bool found = task_.loaded_sticking().solve(start, tries, task_.limits.deadline_s, answer, work);
  report.add(work, "");
  return found;
}

void StickingGuess::note(bool was_right) {
  wrong_guesses_ = was_right ? 0 : wrong_guesses_ + 1;
  steps_without_guess_ = wrong_guesses_;
}

}  // namespace lcpbench
