#include "study/store/store_files.h"

#include <system_error>

#include "core/error.h"
#include "study/store/sqlite.h"

namespace lcpbench {

std::filesystem::path followed(const std::filesystem::path& file) {
  constexpr int kMostLinks = 40;  // as the kernel has it: links may lead in a circle
  std::filesystem::path target = file;
  std::error_code error;
  for (int links = 0; links < kMostLinks && std::filesystem::is_symlink(target, error); ++links) {
    const std::filesystem::path next = std::filesystem::read_symlink(target, error);
    if (error) break;
    target = target.parent_path() / next;  // an absolute one replaces it
  }
  return target;
}

std::filesystem::path side_file(const std::filesystem::path& store, const char* suffix) {
  return followed(store).string() + suffix;
}

bool has_other_names(const std::filesystem::path& file) {
  std::error_code error;
  const auto names = std::filesystem::hard_link_count(file, error);
  return !error && names > 1;
}

void refuse_folder(const std::filesystem::path& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) {
    throw InputError(file.string() + ": is a folder, expected a store");
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

void remove_side_files(const std::filesystem::path& store) {
  for (const char* suffix : {"-wal", "-shm", "-journal"}) std::filesystem::remove(side_file(store, suffix));
}

}  // namespace lcpbench
