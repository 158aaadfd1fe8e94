#pragma once

#include <functional>
#include <memory>

#include "native/contacts/budgeted_solver.h"

namespace lcpbench {

/// friction_ipm. Takes no start: its first convex problem is that of rest.
class FrictionIpmSolver : public BudgetedSolver {
 public:
  /// Solves the first convex problem alone, and claims its answer if that solves the whole problem; else z is that of
  /// the convex problem, with kIterationLimit.
  /// @param is_refuted  asked once, after a few steps, with the z reached by then
  /// @returns false: that said yes, and nothing was solved
  virtual bool solve_convex(const Budget& budget, const std::function<bool(const Vector& z)>& is_refuted,
                            Answer& answer) = 0;
};

/// At its defaults.
std::unique_ptr<FrictionIpmSolver> make_friction_ipm();

}  // namespace lcpbench
