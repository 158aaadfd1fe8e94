#pragma once

#include "adapters/capture/engine.h"
#include "core/problem.h"

namespace lcpbench::capture {

/// The bodies with their contacts, or the contact problem of robots.
std::variant<RigidScene, ContactProblem> contacts_of(const Snapshot& snapshot);
/// The problem of a step. It has the same bits as the problem that is read back from the capture's file.
Problem problem_of(const Snapshot& snapshot);

}  // namespace lcpbench::capture
