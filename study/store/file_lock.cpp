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

// The locked byte is far behind those that SQLite locks, and behind any content.
constexpr off_t kLockedByte = off_t{1} << 62;

/// Another process can delete or replace the file between opening and locking it: such a lock guards nothing.
bool still_named(int descriptor, const std::filesystem::path& file) {
  struct stat opened {};
  struct stat named {};
  return fstat(descriptor, &opened) == 0 && stat(file.c_str(), &named) == 0 && opened.st_ino == named.st_ino &&
         opened.st_dev == named.st_dev;
}

struct flock locked_byte() {
  struct flock range {};
  range.l_type = F_WRLCK;
  range.l_whence = SEEK_SET;
  range.l_start = kLockedByte;
  range.l_len = 1;
  return range;
}

/// Some file systems have no locks of bytes: the name's lock has to do there.
bool has_no_such_locks(int error) { return error == EINVAL || error == ENOLCK || error == EOPNOTSUPP; }

/// flock() would do on local disks; over NFS it locks the whole file, and SQLite would wait for us for ever. The lock
/// belongs to the descriptor, not to the process: SQLite's own descriptors come and go.
/// @returns false when another descriptor holds it
bool lock_byte(int descriptor, const std::filesystem::path& file) {
  struct flock range = locked_byte();
  if (fcntl(descriptor, F_OFD_SETLK, &range) == 0) return true;
  if (errno == EAGAIN || errno == EACCES) return false;
  if (has_no_such_locks(errno)) return true;
  throw InputError(file.string() + ": " + std::strerror(errno));
}

bool byte_is_locked(const std::filesystem::path& file) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;  // who reads the file finds the cause
  struct flock range = locked_byte();
  const int result = fcntl(descriptor, F_OFD_GETLK, &range);
  const int cause = errno;
  close(descriptor);
  if (result == 0) return range.l_type != F_UNLCK;
  if (has_no_such_locks(cause)) return false;
  throw InputError(file.string() + ": " + std::strerror(cause));
}

bool name_is_locked(const std::filesystem::path& lock_file) {
  const int descriptor = open(lock_file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0 && errno == ENOENT) return false;
  if (descriptor < 0) throw InputError(lock_file.string() + ": " + std::strerror(errno));
  const bool locked = flock(descriptor, LOCK_SH | LOCK_NB) == 0;
  const int cause = errno;
  close(descriptor);
  if (locked || cause == EWOULDBLOCK) return !locked;
  throw InputError(lock_file.string() + ": " + std::strerror(cause));
}

}  // namespace

FileLock::FileLock(const std::filesystem::path& file, bool create) : lock_file_(side_file(file, ".lock")) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (true) {
    if (lock_name()) {
      try {
        if (lock_file(file, create)) return;
      } catch (const InputError&) {
        release();
        throw;
      }
    }
    release();
    if (std::chrono::steady_clock::now() > deadline) {
      throw InputError(file.string() + ": another process is writing this store");
    }
    std::this_thread::sleep_for(kRetryAfter);
  }
}

FileLock::~FileLock() { release(); }

bool FileLock::lock_name() {
  const int descriptor = open(lock_file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor < 0) {
    throw InputError(fmt::format("{}: cannot be made beside the store: {}", lock_file_.string(), std::strerror(errno)));
  }
  const bool locked = flock(descriptor, LOCK_EX | LOCK_NB) == 0;
  const int cause = errno;
  if (locked && still_named(descriptor, lock_file_)) {
    name_descriptor_ = descriptor;
    return true;
  }
  close(descriptor);
  if (!locked && cause != EWOULDBLOCK) throw InputError(lock_file_.string() + ": " + std::strerror(cause));
  return false;
}

bool FileLock::lock_file(const std::filesystem::path& file, bool create) {
  file_descriptor_ = open(file.c_str(), O_RDWR | O_CLOEXEC | (create ? O_CREAT : 0), 0644);
  if (file_descriptor_ < 0) {
    if (errno == ENOENT && !create) return true;
    throw InputError(file.string() + ": " + std::strerror(errno));
  }
  return lock_byte(file_descriptor_, file) && still_named(file_descriptor_, file);
}

/// The owner of the name's lock deletes its file.
void FileLock::release() {
  if (file_descriptor_ >= 0) close(file_descriptor_);
  if (name_descriptor_ >= 0) {
    unlink(lock_file_.c_str());
    close(name_descriptor_);
  }
  file_descriptor_ = name_descriptor_ = -1;
}

FileLock::Holder FileLock::holder(const std::filesystem::path& file) {
  if (name_is_locked(side_file(file, ".lock"))) return Holder::kUnderThisName;
  // The file itself is opened only where it has to be: closing it ends the locks that SQLite holds on it for other
  // connections of this process.
  if (!has_other_names(file) || !byte_is_locked(file)) return Holder::kNobody;
  // Its owner may have begun under this name in the meantime.
  return name_is_locked(side_file(file, ".lock")) ? Holder::kUnderThisName : Holder::kUnderAnotherName;
}

}  // namespace lcpbench
