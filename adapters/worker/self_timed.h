#pragma once

#include "core/timed_solve.h"

namespace lcpbench {

/// What a Solver is besides when its work is done in another process: clocks around its calls would count the transport
/// to that process, and the clocks of this thread would miss the work.
class SelfTimed {
 public:
  virtual ~SelfTimed() = default;

  /// Loads and solves, as timed_solve() does. times.transport_s is what is part of neither. @pre usable()
  virtual void run(const Problem& problem, const TimedRequest& request, TimedAnswer& result) = 0;

  /// False once nothing more can be solved: the worker ends, and the next problem gets a fresh one. Asked before each
  /// problem, and after it.
  virtual bool usable() const = 0;
};

}  // namespace lcpbench
