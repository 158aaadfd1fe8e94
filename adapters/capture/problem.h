#pragma once

#include "adapters/capture/engine.h"
#include "core/problem.h"

namespace lcpbench::capture {

/// The problem of a step, the same bits that its file will have: capture.h writes numbers that read back.
Problem problem_of(const Snapshot& snapshot);

}  // namespace lcpbench::capture
