#pragma once

#include <csignal>
#include <filesystem>
#include <string>
#include <string_view>

namespace lcpbench {

/// How many WholeFiles there are that are written in place. Their reader may never come, and nothing of them can be
/// kept: an interrupt may end the process at once.
extern volatile std::sig_atomic_t files_in_place;

/// A file that is written whole or not at all. The text goes to a draft beside the file, `FILE.part`. commit() renames
/// the complete draft to the file. Until then the old file stays as it was.
///
/// The draft is locked: another command with the same output is refused. The lock ends with the process, and the next
/// process uses a draft again that a killed process left. Symbolic links are followed. /dev/null, a pipe and other
/// things that are no regular files have no draft and no lock: they are written in place.
class WholeFile {
 public:
  /// Makes an empty draft. Waits two seconds for another process that writes the same file. @throws InputError when
  /// that does not end, or the file cannot be written
  explicit WholeFile(const std::filesystem::path& file);
  /// Deletes the draft, unless it was committed.
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  /// Where to write.
  const std::filesystem::path& draft() const { return draft_; }
  /// The file to replace, with links followed.
  const std::filesystem::path& place() const { return place_; }
  bool had_content() const { return had_content_; }

  /// Writes the draft's whole content. @throws InputError
  void write(std::string_view text) const;

  /// Replaces the file by the complete draft. @throws InputError
  void commit() { commit_as(place_); }
  /// The same for another file, on the same file system.
  void commit_as(const std::filesystem::path& place);

 private:
  [[noreturn]] void fail(const std::string& cause) const;

  std::filesystem::path file_;  ///< as messages name it
  std::filesystem::path place_;
  std::filesystem::path draft_;
  bool had_content_ = false;
  int descriptor_ = -1;
};

/// Opens a file, and makes it if it does not exist. Then locks it: the lock ends when the descriptor is closed, or the
/// process ends. Waits two seconds for another owner.
/// @param needs_lock  false: on a file system without locks the file is opened without a lock
/// @returns the descriptor; -1 if the other owner still has the lock. @throws std::system_error
int open_locked(const std::filesystem::path& file, bool needs_lock);

/// The text of a file of at most kMaxFileBytes. @param what  "problem file": what is expected, for errors
/// @throws InputError, also for an empty and for a binary file
std::string read_text(const std::filesystem::path& file, const char* what);

/// Writes a WholeFile. @throws InputError when it cannot be written
void write_file(const std::filesystem::path& file, std::string_view text);

/// The file that a name leads to: symbolic links are followed, also where the last one leads to no file yet.
std::filesystem::path followed(const std::filesystem::path& file);

}  // namespace lcpbench
