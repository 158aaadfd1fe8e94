#pragma once

#include <filesystem>
#include <string>

#include "study/store/store.h"

namespace lcpbench {

/// Writes `report.html` (one file; links lead to the others), `summary.json`, `tables/*.csv` and `figures/*.svg` into a
/// folder, which is made where it is missing; files of the same names are replaced, others are left alone. Nothing is
/// solved again.
/// @throws InputError when the store cannot be read or a file cannot be written.
void write_report(Store& store, const std::filesystem::path& folder);

}  // namespace lcpbench
