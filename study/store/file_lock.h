#pragma once

#include <filesystem>

namespace lcpbench {

/// An exclusive lock on a file, held through `FILE.lock` beside it, which also guards a file that does not exist yet. It
/// ends with the process, however that ends; child processes do not inherit it.
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
