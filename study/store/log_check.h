#pragma once

#include <filesystem>

namespace lcpbench {

/// SQLite takes the write-ahead log of a killed writer up to the first transaction that has a frame which is not what
/// was written, since a kill or a power cut can leave the last one incomplete. This tells damage from that: committed
/// transactions stand behind a damaged one, and would be lost without a word. Damage in the last transaction is not
/// told from a power cut: SQLite drops that transaction whole. Does nothing where there is no log.
/// @pre no process is writing the store. @throws InputError when the log is damaged.
void check_log(const std::filesystem::path& store);

}  // namespace lcpbench
