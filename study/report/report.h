#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "study/replay/replay_folder.h"
#include "study/summary/summary.h"
#include "study/store/store.h"

namespace lcpbench {

/// Writes `report.html` (one file; links lead to the others), `summary.json`, `tables/*.csv` and `figures/*.svg` into a
/// folder, which is made where it is missing; files of the same names are replaced, others are left alone. Nothing is
/// solved again. Replays have a section, the table `replay.csv`, and `replay` in the summary.
/// @throws InputError when the store cannot be read or a file cannot be written.
void write_report(Store& store, const std::filesystem::path& folder, const std::vector<ReplayedFiles>& replays = {});

// What a store says, in text for the terminal.

/// The answer: for each kind of contacts the solver to use, the more accurate ones that cost more, the best of Bullet
/// and of ODE beside them with the factors in time, and at the end who said solved and was wrong. At most so many
/// lines, unless a sentence takes more. Serves half-filled stores.
std::string answer_text(const Summary& summary, int width, std::size_t lines);

/// All results: per set one row for each solver with the share solved and its 95 % interval, false claims, giving up,
/// median time, time ratio to the reference, and the 99th percentile of the error; sweeps as worst, average and best.
/// Serves half-filled stores.
std::string table_text(const Summary& summary, int width);

}  // namespace lcpbench
