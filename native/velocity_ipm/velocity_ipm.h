#pragma once

#include <memory>

#include "native/contacts/budgeted_solver.h"

namespace lcpbench {

/// At the defaults of velocity_ipm. A start is ignored.
std::unique_ptr<BudgetedSolver> make_velocity_ipm();

}  // namespace lcpbench
