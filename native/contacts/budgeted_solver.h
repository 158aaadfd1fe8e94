#pragma once

#include <limits>

#include "core/compliance.h"
#include "core/solver.h"

namespace lcpbench {

/// Whether no contact has friction and all yield. Some methods take such a problem as it is, and any other soft one by
/// its rigid equivalent: before each load they choose between their capabilities and with_compliance() of them.
inline bool yields_without_friction(const Problem& problem) {
  const ContactProblem* contact = problem.kind() != ProblemKind::kLcp ? problem.contact() : nullptr;
  return contact != nullptr && !contact->frictional() && every_contact_yields(*contact);
}
constexpr Capabilities with_compliance(Capabilities capabilities) {
  capabilities.compliance = true;
  return capabilities;
}

/// What one solve may take, and what it aims at.
struct Budget {
  const Vector* start = nullptr;  ///< n, a guess at z
  double error = 0;  ///< velocity residual, relative to the scale of each island, that an answer may leave; 0: the
                     ///< method's own
  double work = std::numeric_limits<double>::infinity();
  double deadline_s = std::numeric_limits<double>::infinity();  ///< on wall_clock_s()
};

/// A solver of contact problems whose solves can be ended by a budget of work, so that several can take turns at one
/// problem.
///
/// Work is counted in multiplications of doubles, or what takes as long; it depends on the data alone, never on a
/// clock, so that whoever shares work out gets the same answers on every machine and under every load.
class BudgetedSolver : public Solver {
 public:
  /// As solve(), but that it ends when about so much work is done: then with kIterationLimit, and the best z so far.
  /// Allocates nothing where solve() allocates nothing.
  /// @returns whether the solve has ended by itself
  virtual bool solve_within(const Budget& budget, Answer& answer) = 0;

  /// Of the last solve.
  virtual double work() const = 0;

  /// Velocity residual in double of the z that the last solve_within() wrote, relative to the scale of each island, of
  /// the worst island; infinity where it found none.
  virtual double residual(const Answer& answer) = 0;
};

}  // namespace lcpbench
