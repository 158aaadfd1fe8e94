#include "study/store/file_lock.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/error.h"
#include "study/store/store_files.h"

namespace lcpbench {
namespace {

// A child that was being started when its parent was killed holds a copy of the parent's descriptor, and so the lock,
// until its own program takes over: a moment, on a busy machine a long one.
constexpr auto kPatience = std::chrono::seconds(2);
constexpr auto kRetryAfter = std::chrono::milliseconds(20);

/// Another process can delete or replace the file between opening and locking it: such a lock guards nothing.
bool still_named(int descriptor, const std::filesystem::path& file) {
  struct stat opened {};
  struct stat named {};
  return fstat(descriptor, &opened) == 0 && stat(file.c_str(), &named) == 0 && opened.st_ino == named.st_ino &&
         opened.st_dev == named.st_dev;
}

}  // namespace

FileLock::FileLock(const std::filesystem::path& file) : lock_file_(side_file(file, ".lock")) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (!lock()) {
    if (std::chrono::steady_clock::now() > deadline) {
      throw InputError(file.string() + ": another process is writing this store");
    }
    std::this_thread::sleep_for(kRetryAfter);
  }
}

/// The owner deletes the lock's file.
FileLock::~FileLock() {
  unlink(lock_file_.c_str());
  close(descriptor_);
}

bool FileLock::lock() {
  const int descriptor = open(lock_file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor < 0) {
    throw InputError(fmt::format("{}: cannot be made beside the store: {}", lock_file_.string(), std::strerror(errno)));
  }
  const bool locked = flock(descriptor, LOCK_EX | LOCK_NB) == 0;
  const int cause = errno;
  if (locked && still_named(descriptor, lock_file_)) {
    descriptor_ = descriptor;
    return true;
  }
  close(descriptor);
  if (!locked && cause != EWOULDBLOCK) throw InputError(lock_file_.string() + ": " + std::strerror(cause));
  return false;
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
