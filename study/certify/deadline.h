#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <exception>
#include <limits>

namespace lcpbench::exact {

/// Thrown inside a computation to end it when its Deadline has passed; the certifier catches it.
struct TimePassed : std::exception {
  const char* what() const noexcept override { return "the time limit passed"; }
};

/// A limit on the time since construction, by a steady clock; or on the work done, which is the same on every machine.
/// One object per thread: passed() and check() are const, but count the work.
class Deadline {
 public:
  /// With NaN, passed() is true at once.
  explicit Deadline(double seconds) : limit_s_(seconds) {}
  /// Passes when the calls of passed() and check() have counted so much work in all, however long that takes: left_s()
  /// is infinite.
  static Deadline after_work(std::int64_t work) {
    Deadline deadline(std::numeric_limits<double>::infinity());
    deadline.counts_work_ = true;
    deadline.work_left_ = work;
    return deadline;
  }

  double elapsed_s() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  double left_s() const { return limit_s_ - elapsed_s(); }
  /// @param work  work since the last call, >= 0, in steps of some microseconds; not used by a limit on time
  bool passed(std::int64_t work = 1) const {
    if (!counts_work_) return !(elapsed_s() < limit_s_);
    work_left_ = std::max<std::int64_t>(work_left_ - work, 0);
    return work_left_ == 0;
  }

  /// Before work that nothing can interrupt. @param steps  what it may take, see passed()
  /// @throws TimePassed where that is more than what is left
  void require(double steps) const {
    constexpr double kStep_s = 5e-6;
    constexpr double kMost = 1e15;
    if (passed(static_cast<std::int64_t>(std::min(steps, kMost))) || steps * kStep_s > left_s()) throw TimePassed();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double limit_s_ = std::numeric_limits<double>::infinity();
  bool counts_work_ = false;
  mutable std::int64_t work_left_ = 0;
};

}  // namespace lcpbench::exact
