#pragma once

#include <memory>

#include "native/contacts/resumable_solver.h"

namespace lcpbench {

/// At its defaults. A start gives the first impulses from which the contacts yield.
std::unique_ptr<ResumableSolver> make_proximal_newton();

}  // namespace lcpbench
