#include "study/store/file_lock.h"

#include <cerrno>
#include <cstring>
#include <system_error>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "core/error.h"
#include "core/io/whole_file.h"
#include "study/store/store_files.h"

namespace lcpbench {

FileLock::FileLock(const std::filesystem::path& file) : lock_file_(side_file(file, ".lock")) {
  try {
    descriptor_ = open_locked(lock_file_, true);
  } catch (const std::system_error& error) {
    throw InputError(lock_file_.string() + ": " + error.code().message());
  }
  if (descriptor_ < 0) throw InputError(file.string() + ": another process is writing this store");
}

/// The owner deletes the lock's file.
FileLock::~FileLock() {
  unlink(lock_file_.c_str());
  close(descriptor_);
}

bool FileLock::is_held(const std::filesystem::path& file) {
  const std::filesystem::path lock_file = side_file(file, ".lock");
  const int descriptor = open(lock_file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0 && errno == ENOENT) return false;
  if (descriptor < 0) throw InputError(lock_file.string() + ": " + std::strerror(errno));
  const bool locked = flock(descriptor, LOCK_SH | LOCK_NB) == 0;
  const int cause = errno;
  close(descriptor);
  if (locked || cause == EWOULDBLOCK) return !locked;
  throw InputError(lock_file.string() + ": " + std::strerror(cause));
}

}  // namespace lcpbench
