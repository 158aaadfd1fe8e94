#include "study/file_lock.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/error.h"

namespace lcpbench {
namespace {

// A child that was being started when its parent was killed holds a copy of the parent's descriptor, and so the lock,
// until its own program takes over: a moment, on a busy machine a long one.
constexpr auto kPatience = std::chrono::seconds(2);
constexpr auto kRetryAfter = std::chrono::milliseconds(20);

/// The last owner deletes the lock file: a lock on a file that no longer has its name guards nothing.
bool still_named(int descriptor, const std::filesystem::path& file) {
  struct stat opened {};
  struct stat named {};
  return fstat(descriptor, &opened) == 0 && stat(file.c_str(), &named) == 0 && opened.st_ino == named.st_ino &&
         opened.st_dev == named.st_dev;
}

}  // namespace

FileLock::FileLock(const std::filesystem::path& file) : lock_file_(file.string() + ".lock") {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (true) {
    descriptor_ = open(lock_file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor_ < 0) throw InputError(lock_file_.string() + ": " + std::strerror(errno));
    const bool locked = flock(descriptor_, LOCK_EX | LOCK_NB) == 0;
    const int cause = errno;
    if (locked && still_named(descriptor_, lock_file_)) return;
    close(descriptor_);
    if (locked) continue;
    if (cause != EWOULDBLOCK) throw InputError(file.string() + ": " + std::strerror(cause));
    if (std::chrono::steady_clock::now() > deadline) {
      throw InputError(file.string() + ": another process is writing this store");
    }
    std::this_thread::sleep_for(kRetryAfter);
  }
}

FileLock::~FileLock() {
  unlink(lock_file_.c_str());
  close(descriptor_);
}

}  // namespace lcpbench
