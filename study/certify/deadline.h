#pragma once

#include <algorithm>
#include <chrono>
#include <exception>
#include <limits>

namespace lcpbench::exact {

/// Ends a computation whose time is up, from within; the certifier catches it.
struct TimePassed : std::exception {
  const char* what() const noexcept override { return "the time limit passed"; }
};

/// A point in time on the wall clock after which work stops.
class Deadline {
 public:
  explicit Deadline(double seconds) : limit_s_(seconds) {}

  double elapsed_s() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  double left_s() const { return limit_s_ - elapsed_s(); }
  /// True for a limit of NaN too.
  bool passed() const { return !(elapsed_s() < limit_s_); }
  /// The sooner of this one and `seconds` from now.
  Deadline within(double seconds) const { return Deadline(std::min(seconds, left_s())); }

  /// For loops whose result is of no use when it is not complete. @throws TimePassed
  void check() const {
    if (passed()) throw TimePassed();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double limit_s_ = std::numeric_limits<double>::infinity();
};

}  // namespace lcpbench::exact
