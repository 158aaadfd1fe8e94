#include "study/store/store_files.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "core/error.h"
#include "study/store/sqlite.h"

namespace lcpbench {

std::filesystem::path side_file(const std::filesystem::path& store, const char* suffix) {
  return followed(store).string() + suffix;
}

void refuse_other_names(const std::filesystem::path& file) {
  std::error_code error;
  const auto names = std::filesystem::hard_link_count(file, error);
  if (error || names == 1) return;
  throw InputError(file.string() + ": the file has other names (hard links), which would miss what is written under "
                   "this one; write a copy");
}

void refuse_folder(const std::filesystem::path& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) {
    throw InputError(file.string() + ": is a folder, expected a store");
  }
  if (std::filesystem::exists(file, ignored) && !std::filesystem::is_regular_file(file, ignored)) {
    throw InputError(file.string() + ": is not a regular file");
  }
}

void roll_back_journal(const std::filesystem::path& store) {
  std::error_code ignored;
  if (!std::filesystem::exists(side_file(store, "-journal"), ignored)) return;
  sqlite::Database(store, sqlite::Mode::kReadWrite).integer("SELECT COUNT(*) FROM sqlite_master");
}

bool has_log(const std::filesystem::path& store) {
  std::error_code error;
  const auto size = std::filesystem::file_size(side_file(store, "-wal"), error);
  return !error && size > 0;
}

void read_ahead(const std::filesystem::path& store) {
  std::vector<char> buffer(std::size_t{1} << 20);
  std::ifstream stream(store, std::ios::binary);
  while (stream.read(buffer.data(), std::ssize(buffer))) continue;
}

void remove_side_files(const std::filesystem::path& store) {
  for (const char* suffix : {"-wal", "-shm", "-journal"}) std::filesystem::remove(side_file(store, suffix));
}

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
