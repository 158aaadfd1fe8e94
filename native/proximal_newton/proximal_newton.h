#pragma once

#include <memory>

#include "core/contact_problem.h"
#include "native/contacts/resumable_solver.h"

namespace lcpbench {

/// Whether the inertia is given as G, or by factors of full rank.
bool proximal_newton_takes(const ContactProblem& contact);

/// At its defaults. A start gives the first impulses from which the contacts yield.
std::unique_ptr<ResumableSolver> make_proximal_newton();

}  // namespace lcpbench
