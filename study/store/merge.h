#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "study/store/store.h"

namespace lcpbench {

struct MergeOutcome {
  std::int64_t cells = 0;  ///< in the merged store
  /// Rows of equal ids that contradict each other, a line each; at most 20 of a table of an input. Empty: merged.
  std::vector<std::string> conflicts;
  std::vector<std::string> notices;  ///< rows that an input had lost before, one line each
};

/// Joins stores into `out`, which may exist and then counts as the first of them. Rows are joined by id. Where several
/// stores have an answer, its timings are those of the first, and so is its `detail`, a text for people that may depend
/// on the clock. A problem's certificate is the first that is not open. All runs are kept. All or nothing: when two
/// stores disagree on a row, `out` stays as it was and the conflicts are returned. A symbolic link is followed. What a
/// killed call left is thrown away.
/// @param mixed  joins also stores that runs of different versions or plans filled, if the bound of the verdict is one
/// @throws InputError when a file is no store, or one of another version or plan, or `out` is in use or cannot be
/// written.
MergeOutcome merge_stores(const std::filesystem::path& out, const std::vector<std::filesystem::path>& inputs,
                          const Waiting& waiting = {}, bool mixed = false);

}  // namespace lcpbench
