#include "study/file_lock.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/error.h"

namespace lcpbench {
namespace {

/// The last owner deletes the lock file: a lock on a file that no longer has its name guards nothing.
bool still_named(int descriptor, const std::filesystem::path& file) {
  struct stat opened {};
  struct stat named {};
  return fstat(descriptor, &opened) == 0 && stat(file.c_str(), &named) == 0 && opened.st_ino == named.st_ino &&
         opened.st_dev == named.st_dev;
}

}  // namespace

FileLock::FileLock(const std::filesystem::path& file) : lock_file_(file.string() + ".lock") {
  while (true) {
    descriptor_ = open(lock_file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor_ < 0) throw InputError(lock_file_.string() + ": " + std::strerror(errno));
    if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      const int cause = errno;
      close(descriptor_);
      throw InputError(file.string() + ": " +
                       (cause == EWOULDBLOCK ? "another process is writing this store" : std::strerror(cause)));
    }
    if (still_named(descriptor_, lock_file_)) return;
    close(descriptor_);
  }
}

FileLock::~FileLock() {
  unlink(lock_file_.c_str());
  close(descriptor_);
}

}  // namespace lcpbench
