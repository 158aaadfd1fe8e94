#pragma once

#include <cstddef>
#include <string>

#include "study/report/summary.h"

// What a store says, in text for the terminal.

namespace lcpbench {

/// The answer: for each kind of contacts the solver to use, the more accurate ones that cost more, the best of Bullet
/// and of ODE beside them with the factors in time, and at the end who said solved and was wrong. At most so many
/// lines, unless a sentence takes more. Serves half-filled stores.
std::string answer_text(const Summary& summary, int width, std::size_t lines);

/// All results: per set one row for each solver with the share solved and its 95 % interval, false claims, giving up,
/// median time, time ratio to the reference, and the 99th percentile of the error; sweeps as worst, average and best.
/// Serves half-filled stores.
std::string table_text(const Summary& summary, int width);

}  // namespace lcpbench
