#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "core/swept_solver.h"

namespace lcpbench {

/// Makes the solver of one parameterisation.
using OpenCell = std::function<std::unique_ptr<TimedSolver>()>;

/// Answers a problem at the cells of a sweep one after the other, each with a solver of its own, and puts answers
/// of the same claim, vectors (bit for bit), counters and detail together; their times are the means over the cells
/// that gave them. A solver is opened when its cell is first run and kept, unless problems are large or `keep` is
/// false: then the dozens of workspaces, or worker processes, would add up.
std::unique_ptr<SweptSolver> one_by_one(std::vector<OpenCell> cells, bool keep);

}  // namespace lcpbench
