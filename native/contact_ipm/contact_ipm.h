#pragma once

#include <memory>

#include "native/contacts/budgeted_solver.h"

namespace lcpbench {

/// At its defaults. Takes no start.
std::unique_ptr<BudgetedSolver> make_contact_ipm();

}  // namespace lcpbench
