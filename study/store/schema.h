#pragma once

#include <string>

namespace lcpbench {

/// The store: one SQLite file; docs/reference/store.md says how to read it. Ids are 63-bit hashes of what they identify
/// (set name; solver name, settings, library, version, instruction-set level and sweep; set, seed and trial; the cells
/// of a group; vector content), so that stores written apart merge by INSERT OR IGNORE and equal runs hold equal rows
/// but for `timings` and `runs`.
///
/// Verdicts need every answer to a problem (one solver's solution proves solvable what another missed), so `verdicts`
/// holds what one answer shows by itself; the view `judged` adds the problem's truth and gives claim and verdict side
/// by side. Nothing of it needs a solver to run again: `vectors` keeps every answer exactly.
///
/// `checksum` is a hash of the row's other columns, see study/store/row_checksum.h; `vectors` and `cell_groups` have
/// ids that are one.
std::string store_schema();

/// The columns of `verdicts` that are metrics, with commas between them.
std::string metric_columns();

}  // namespace lcpbench
