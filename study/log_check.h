#pragma once

#include <filesystem>

namespace lcpbench {

/// SQLite takes the write-ahead log of a killed writer up to the first frame that is not what was written, since a kill
/// can cut the last one. This tells damage from a cut: behind a damaged frame stand committed ones, which would be lost
/// without a word. A damaged frame of the last transaction is not told from a cut. Does nothing where there is no log.
/// @pre no process is writing the store. @throws InputError when the log is damaged.
void check_log(const std::filesystem::path& store);

}  // namespace lcpbench
