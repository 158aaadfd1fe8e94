#pragma once

#include <memory>

#include "native/contacts/resumable_solver.h"

namespace lcpbench {

/// At its defaults. Takes no start: its first convex problem is that of rest.
std::unique_ptr<ResumableSolver> make_friction_ipm();

}  // namespace lcpbench
