#include "core/io/whole_file.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/io/problem_checks.h"

namespace lcpbench {
namespace {

namespace fs = std::filesystem;

// A process that is being started holds a copy of a killed writer's descriptor, and so the lock, for a moment.
constexpr auto kPatience = std::chrono::seconds(2);
constexpr auto kRetryAfter = std::chrono::milliseconds(20);

}  // namespace

fs::path followed(const fs::path& file) {
  constexpr int kMostLinks = 40;  // as the kernel has it: links may lead in a circle
  fs::path target = file;
  std::error_code error;
  for (int links = 0; links < kMostLinks && fs::is_symlink(target, error); ++links) {
    const fs::path next = fs::read_symlink(target, error);
    if (error) break;
    target = target.parent_path() / next;  // an absolute one replaces it
  }
  return target;
}

WholeFile::WholeFile(const fs::path& file) : file_(file), place_(followed(file)), draft_(place_) {
  struct stat found {};
  const bool exists = stat(place_.c_str(), &found) == 0;
  if (exists && S_ISDIR(found.st_mode)) fail("is a folder");
  if (exists && access(place_.c_str(), W_OK) != 0) fail(std::strerror(errno));
  if (exists && !S_ISREG(found.st_mode)) return;
  had_content_ = exists && found.st_size > 0;
  draft_ += ".part";
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (!lock()) {
    if (std::chrono::steady_clock::now() > deadline) fail("another process is writing it");
    std::this_thread::sleep_for(kRetryAfter);
  }
  if (ftruncate(descriptor_, 0) != 0 || (exists && fchmod(descriptor_, found.st_mode & 07777) != 0)) {
    const int cause = errno;
    close(descriptor_);
    fail(std::strerror(cause));
  }
}

WholeFile::~WholeFile() {
  if (descriptor_ < 0) return;
  unlink(draft_.c_str());  // before the lock ends
  close(descriptor_);
}

/// @returns false when another process has the lock
bool WholeFile::lock() {
  const int descriptor = open(draft_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (descriptor < 0) fail(std::strerror(errno));
  // Some file systems have no locks: there nobody is refused.
  const bool locked = flock(descriptor, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
  // Between opening and locking the draft may have taken its place, or been deleted.
  struct stat opened {};
  struct stat named {};
  const bool same = fstat(descriptor, &opened) == 0 && stat(draft_.c_str(), &named) == 0 &&
                    opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
  if (locked && same) {
    descriptor_ = descriptor;
    return true;
  }
  close(descriptor);
  return false;
}

void WholeFile::commit_as(const fs::path& place) {
  if (descriptor_ < 0) return;
  std::error_code error;
  fs::rename(draft_, place, error);
  if (error) fail(error.message());
  close(descriptor_);
  descriptor_ = -1;
}

void WholeFile::fail(const std::string& cause) const {
  throw input_error(file_.string(), "cannot be written: " + cause);
}

void WholeFile::write(std::string_view text) const {
  errno = 0;
  std::ofstream stream(draft_, std::ios::binary | std::ios::trunc);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  stream.close();
  if (!stream) fail(errno != 0 ? std::strerror(errno) : "unknown cause");
}

void write_file(const fs::path& file, std::string_view text) {
  WholeFile whole(file);
  whole.write(text);
  whole.commit();
}

}  // namespace lcpbench
