#pragma once

#include <memory>

#include "native/contacts/resumable_solver.h"

namespace lcpbench {

/// At its defaults. If a solve in parts has a start, the first slip bounds are those of the velocity that it gives.
std::unique_ptr<ResumableSolver> make_friction_ipm();

}  // namespace lcpbench
