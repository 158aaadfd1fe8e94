#include "core/io/whole_file.h"

#include <algorithm>
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

/// The regular file's size, after every reason not to read it.
std::uintmax_t checked_size(const fs::path& file, const char* what) {
  const std::string origin = file.string();
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) throw input_error(origin, "no such file");
  if (error) throw input_error(origin, error.message());
  if (status.type() == fs::file_type::directory) {
    throw input_error(origin, std::string("is a folder, expected a ") + what);
  }
  if (status.type() != fs::file_type::regular) throw input_error(origin, "is not a regular file");
  const std::uintmax_t size = fs::file_size(file, error);
  if (error) throw input_error(origin, error.message());
  if (size > kMaxFileBytes) {
    throw input_error(origin, std::to_string(size) + " bytes, at most " + std::to_string(kMaxFileBytes) + " are read");
  }
  return size;
}

/// Refuses binary files, holes of zeros first of all, before the whole is read.
void check_text(std::string_view beginning, const std::string& origin) {
  if (beginning.empty()) throw input_error(origin, "empty file");
  if (beginning.find('\0') != std::string_view::npos) throw input_error(origin, "has NUL bytes: not a text file");
}

}  // namespace

volatile std::sig_atomic_t files_in_place = 0;

std::string read_text(const fs::path& file, const char* what) {
  const std::string origin = file.string();
  const std::uintmax_t size = checked_size(file, what);
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw input_error(origin, std::string("cannot be opened: ") + std::strerror(errno));
  constexpr std::uintmax_t kBeginning = 4096;
  std::string text(static_cast<std::size_t>(std::min(size, kBeginning)), '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  check_text(std::string_view(text).substr(0, static_cast<std::size_t>(stream.gcount())), origin);
  const std::size_t begun = text.size();
  text.resize(static_cast<std::size_t>(size));
  stream.read(text.data() + begun, static_cast<std::streamsize>(text.size() - begun));
  if (stream.bad() || static_cast<std::size_t>(stream.gcount()) != text.size() - begun) {
    throw input_error(origin, "cannot be read to its end");
  }
  return text;
}

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

int open_locked(const fs::path& file, bool needs_lock) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (true) {
    const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (descriptor < 0) throw std::system_error(errno, std::generic_category());
    const int cause = flock(descriptor, LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
    // Between opening and locking the file may have got another name, or been deleted.
    struct stat opened {};
    struct stat named {};
    const bool same = fstat(descriptor, &opened) == 0 && stat(file.c_str(), &named) == 0 &&
                      opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
    if (cause != EWOULDBLOCK && same && (cause == 0 || !needs_lock)) return descriptor;
    close(descriptor);
    if (cause != 0 && cause != EWOULDBLOCK) throw std::system_error(cause, std::generic_category());
    if (std::chrono::steady_clock::now() > deadline) return -1;
    std::this_thread::sleep_for(kRetryAfter);
  }
}

WholeFile::WholeFile(const fs::path& file) : file_(file), place_(followed(file)), draft_(place_) {
  struct stat found {};
  const bool exists = stat(place_.c_str(), &found) == 0;
  if (exists && S_ISDIR(found.st_mode)) fail("is a folder");
  if (exists && access(place_.c_str(), W_OK) != 0) fail(std::strerror(errno));
  if (exists && !S_ISREG(found.st_mode)) {
    files_in_place = files_in_place + 1;
    return;
  }
  had_content_ = exists && found.st_size > 0;
  draft_ += ".part";
  try {
    descriptor_ = open_locked(draft_, false);
  } catch (const std::system_error& error) {
    fail(error.code().message());
  }
  if (descriptor_ < 0) fail("another process is writing it");
  if (ftruncate(descriptor_, 0) != 0 || (exists && fchmod(descriptor_, found.st_mode & 07777) != 0)) {
    const int cause = errno;
    close(descriptor_);
    fail(std::strerror(cause));
  }
}

WholeFile::~WholeFile() {
  if (draft_ == place_) files_in_place = files_in_place - 1;
  if (descriptor_ < 0) return;
  unlink(draft_.c_str());  // before the lock ends
  close(descriptor_);
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
