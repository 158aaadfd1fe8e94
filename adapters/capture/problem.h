#pragma once

#include "adapters/capture/engine.h"
#include "core/problem.h"

namespace lcpbench::capture {

/// The contact problem of the snapshot's blocks, or without blocks the bodies with their contacts. Checks nothing.
/// @pre with blocks every contact has `rows`, and 0, 2 or 4 edges; without, 0 or 4
std::variant<RigidScene, ContactProblem> contacts_of(const Snapshot& snapshot);
/// The problem of a step.
Problem problem_of(const Snapshot& snapshot);

}  // namespace lcpbench::capture
