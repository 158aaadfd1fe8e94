#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <exception>
#include <limits>

namespace lcpbench::exact {

/// Ends a computation whose time is up, from within; the certifier catches it.
struct TimePassed : std::exception {
  const char* what() const noexcept override { return "the time limit passed"; }
};

/// A point in time on the wall clock after which work stops; or an amount of work, the same on every machine.
class Deadline {
 public:
  explicit Deadline(double seconds) : limit_s_(seconds) {}
  /// Passes when passed() has been told of so much work in all, whatever time it takes: left_s() is infinite.
  static Deadline after_work(std::int64_t work) {
    Deadline deadline(std::numeric_limits<double>::infinity());
    deadline.counts_work_ = true;
    deadline.work_left_ = work;
    return deadline;
  }

  double elapsed_s() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  double left_s() const { return limit_s_ - elapsed_s(); }
  /// True for a limit of NaN too. @param work  done since the last question, in steps of some microseconds
  bool passed(std::int64_t work = 1) const {
    if (!counts_work_) return !(elapsed_s() < limit_s_);
    work_left_ = std::max<std::int64_t>(work_left_ - work, 0);
    return work_left_ == 0;
  }

  /// For loops whose result is of no use when it is not complete. @throws TimePassed
  void check() const {
    if (passed()) throw TimePassed();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double limit_s_ = std::numeric_limits<double>::infinity();
  bool counts_work_ = false;
  mutable std::int64_t work_left_ = 0;
};

}  // namespace lcpbench::exact
