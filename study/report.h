#pragma once

#include <filesystem>
#include <string>

#include "study/store.h"

namespace lcpbench {

/// Writes `report.html` (one self-contained file), `summary.json`, `tables/*.csv` and `figures/*.svg` into a folder,
/// which is made where it is missing; files of the same names are replaced, others are left alone. Nothing is solved
/// again.
/// @returns "" or, in one line, why the report has no figures (gnuplot is missing or failed); it is complete otherwise.
/// @throws InputError when the store cannot be read or a file cannot be written.
std::string write_report(Store& store, const std::filesystem::path& folder);

}  // namespace lcpbench
