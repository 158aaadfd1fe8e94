#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>

#include "study/store.h"
#include "study/summary.h"

namespace lcpbench {

/// Writes `report.html` (one file; links lead to the others), `summary.json`, `tables/*.csv` and `figures/*.svg` into a
/// folder, which is made where it is missing; files of the same names are replaced, others are left alone. Nothing is
/// solved again.
/// @throws InputError when the store cannot be read or a file cannot be written.
void write_report(Store& store, const std::filesystem::path& folder);

/// The results as text, at most 100 columns wide unless a name is longer: per set one row for each solver with the
/// share solved and its 95 % interval, false claims, giving up, median time, time ratio to the reference, and the 99th
/// percentile of the error; sweeps as worst, average and best. Serves half-filled stores.
std::string table_text(const Summary& summary);

/// table_text of a store's summary.
void print_table(Store& store, std::ostream& out);

}  // namespace lcpbench
