#pragma once

#include <filesystem>

#include "core/io/whole_file.h"

namespace lcpbench {

/// A file beside the one that a store's name leads to: its name with a suffix. SQLite has "-journal", "-wal", "-shm".
std::filesystem::path side_file(const std::filesystem::path& store, const char* suffix);

/// @throws InputError when the file has more names than one (hard links): SQLite's log is beside one of them only.
void refuse_other_names(const std::filesystem::path& file);

/// @throws InputError when the name is a folder's: SQLite's own message names no cause.
void refuse_folder(const std::filesystem::path& file);

/// A writer that was killed can leave a journal. Nobody can read the store before SQLite has rolled it back, and SQLite
/// does that only for a connection that may write: this opens one where there is a journal. Does nothing to the journal
/// of a writer that lives. @throws InputError when the journal is there and cannot be rolled back.
void roll_back_journal(const std::filesystem::path& store);

/// True when committed rows may stand in a write-ahead log beside the store.
bool has_log(const std::filesystem::path& store);

/// Reads a file once from its begin to its end, so that the system has it in memory. Who then reads a store by its keys,
/// that is here and there, need not wait for the disk at each page. Does nothing where the file cannot be read.
/// @pre no connection of this process to the store: closing any descriptor of a file ends the locks of SQLite on it
void read_ahead(const std::filesystem::path& store);

/// Deletes the files beside a store. @throws std::filesystem::filesystem_error
void remove_side_files(const std::filesystem::path& store);

/// An exclusive lock on a file, held through `FILE.lock` beside it, which also guards a file that does not exist yet.
/// It ends with the process, however that ends; child processes do not inherit it.
class FileLock {
 public:
  /// Waits two seconds for another owner to end.
  /// @throws InputError when the other owner does not end, or the lock cannot be made.
  explicit FileLock(const std::filesystem::path& file);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

  /// Whether some process holds the lock. @throws InputError where the system does not tell.
  static bool is_held(const std::filesystem::path& file);

 private:
  std::filesystem::path lock_file_;
  int descriptor_ = -1;
};

}  // namespace lcpbench
