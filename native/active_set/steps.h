#pragma once

#include "native/active_set/active_set_engine.h"
#include "native/active_set/arithmetic.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// Counts the steps of a solve, and ends it at the limits that its rules set.
class Steps {
 public:
  /// Both must outlive it.
  Steps(const Rules& rules, Outcome& outcome) : rules_(rules), outcome_(outcome), begin_s_(rules.begin_s) {}

  /// Counts a step, unless a limit forbids it. @returns kSolved, or the limit
  Ending next() {
    if (outcome_.steps >= rules_.max_steps) return Ending::kStepLimit;
    if (outcome_.work >= rules_.max_work) return Ending::kWorkLimit;
    if (outcome_.steps % kStepsPerClockReading == kStepsPerClockReading - 1 && is_expired()) return Ending::kTimeLimit;
    ++outcome_.steps;
    return Ending::kSolved;
  }

  /// Counts the multiplications of a step, with the time that no product takes.
  void add_work(Count multiplications) { outcome_.work += multiplications + kWorkOfStep; }
  void count_factorization() { ++outcome_.factorizations; }

 private:
  static constexpr Count kStepsPerClockReading = 16;
  static constexpr Count kWorkOfStep = 1000;

  bool is_expired() {
    if (!(rules_.time_limit_s < kInfinity<double>)) return false;
    const double now_s = rules_.clock_s();
    if (!(begin_s_ <= now_s)) begin_s_ = now_s;
    return !(now_s - begin_s_ < rules_.time_limit_s);
  }

  const Rules& rules_;
  Outcome& outcome_;
  double begin_s_;  ///< of the solve, on its clock; NaN until that is read
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
