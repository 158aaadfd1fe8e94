#pragma once

#include <cstdint>
#include <vector>

#include "core/timed_solve.h"

namespace lcpbench {

/// One distinct answer of a sweep, and the parameterisations that gave it.
struct SweptAnswer {
  std::vector<std::uint32_t> cells;  ///< their numbers in the sweep, ascending
  TimedAnswer timed;                 ///< what each of them would report if it ran alone, its times included
};

/// Answers a problem at every parameterisation of a sweep.
class SweptSolver {
 public:
  virtual ~SweptSolver() = default;

  /// The answers of all cells: each cell stands in exactly one of them, and no two are equal in claim, vectors,
  /// counters and detail. Ordered by their first cell. Never throws for anything a solver does: that is a claim.
  /// `request.repeat_until_s` is not used: cells of a sweep run once. `request.time_limit_s` holds for each cell.
  virtual void run(const Problem& problem, const TimedRequest& request, std::vector<SweptAnswer>& answers) = 0;
};

}  // namespace lcpbench
