#pragma once

#include <filesystem>

namespace lcpbench {

/// An exclusive lock on a file, under all of its names: it is held through `FILE.lock` beside the file, which also
/// guards a file that does not exist yet, and on the file itself, which may have other names (hard links). It ends with
/// the process, however that ends; child processes do not inherit it.
///
/// No SQLite connection of this process to the file may outlive the lock: closing any descriptor of a file ends the
/// locks that SQLite holds on it.
class FileLock {
 public:
  /// Waits two seconds for another owner to end.
  /// @param create  makes the file, empty, where there is none
  /// @throws InputError when the other owner does not end, or the lock cannot be made.
  explicit FileLock(const std::filesystem::path& file, bool create = false);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

  /// Whether some process holds the lock, and under which name of the file.
  enum class Holder { kNobody, kUnderThisName, kUnderAnotherName };
  /// @throws InputError where the system does not tell.
  static Holder holder(const std::filesystem::path& file);

 private:
  /// Each @returns false when another process has the lock.
  bool lock_name();
  bool lock_file(const std::filesystem::path& file, bool create);
  void release();

  std::filesystem::path lock_file_;
  int name_descriptor_ = -1;
  int file_descriptor_ = -1;
};

}  // namespace lcpbench
