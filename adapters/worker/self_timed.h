#pragma once

#include "core/timed_solve.h"

namespace lcpbench {

/// A second interface of a Solver that works in another process and measures its own times. Clocks around its calls
/// would count the transport to that process, and the CPU clock of this thread would miss the work.
class SelfTimed {
 public:
  virtual ~SelfTimed() = default;

  /// Loads and solves, as timed_solve() does. times.transport_s is the time that belongs to neither. @pre usable()
  virtual void run(const Problem& problem, const TimedRequest& request, TimedAnswer& result) = 0;

  /// False once nothing more can be solved: the worker ends, and the next problem gets a fresh one. Asked before each
  /// problem, and after it.
  virtual bool usable() const { return true; }
};

}  // namespace lcpbench
