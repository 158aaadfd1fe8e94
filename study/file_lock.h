#pragma once

#include <filesystem>

namespace lcpbench {

/// An exclusive lock held through `FILE.lock` beside a file. It ends with the process, however that ends; child
/// processes do not inherit it.
class FileLock {
 public:
  /// Waits two seconds for another owner to end. @throws InputError when it does not, or the lock file cannot be made.
  explicit FileLock(const std::filesystem::path& file);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  std::filesystem::path lock_file_;
  int descriptor_ = -1;
};

}  // namespace lcpbench
