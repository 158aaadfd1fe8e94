#pragma once

#include <memory>

#include "native/contacts/resumable_solver.h"

namespace lcpbench {

/// At its defaults. Takes no start.
std::unique_ptr<ResumableSolver> make_contact_ipm();

}  // namespace lcpbench
