// What a user relies on: two writers never meet in one store, under whatever names, and who has to wait is told for
// what.

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "study/store/merge.h"
#include "tests/study/filled_store.h"

namespace {
int g_flock_error = 0;  ///< what flock() fails with; 0: it works
}

/// In the place of the C library's.
extern "C" int flock(int descriptor, int operation) noexcept {
  if (g_flock_error == 0) return static_cast<int>(syscall(SYS_flock, descriptor, operation));
  errno = g_flock_error;
  return -1;
}

namespace lcpbench {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using StoreSharingTest = FilledStoreTest;

// ----------------------------------------------------------------------------------------------------- many names

TEST_F(StoreSharingTest, SecondWriterIsRefusedUnderEveryNameOfTheFile) {
  fs::create_symlink("s.db", folder_ / "soft.db");
  const Store first = Store::open_for_writing(file_);
  for (const char* name : {"s.db", "soft.db"}) {
    EXPECT_TRUE(contains(input_error([&] { Store::open_for_writing(folder_ / name); }),
                         std::string(name) + ": another process is writing this store"));
  }
  EXPECT_NO_THROW(Store::open_for_reading(folder_ / "soft.db"));
}

/// The log of a writer is beside one name: under another its rows would be missing.
TEST_F(StoreSharingTest, AFileWithHardLinksIsReadAndNotWritten) {
  fs::create_hard_link(file_, folder_ / "hard.db");
  for (const char* name : {"s.db", "hard.db"}) {
    EXPECT_TRUE(contains(input_error([&] { Store::open_for_writing(folder_ / name); }),
                         std::string(name) + ": the file has other names (hard links)"));
    EXPECT_EQ(checked_rows(folder_ / name), before_);
    EXPECT_FALSE(fs::exists(folder_ / (std::string(name) + ".lock")));
  }
}

/// A link that was made while the store was written lacks the log.
TEST_F(StoreSharingTest, AHardLinkMadeDuringTheWritingSaysThatRowsMayBeMissing) {
  const Store writer = Store::open_for_writing(file_);
  fs::create_hard_link(file_, folder_ / "hard.db");
  EXPECT_TRUE(contains(Store::open_for_reading(folder_ / "hard.db").notice(), "its last rows may be missing"));
}

TEST_F(StoreSharingTest, FailureOfALockIsNamedAndIsNoOwner) {
  std::ofstream(file_.string() + ".lock").close();  // of a writer that was killed
  EXPECT_EQ(checked_rows(file_), before_);
  g_flock_error = ENOLCK;
  const std::string reading = input_error([&] { Store::open_for_reading(file_); });
  const std::string writing = input_error([&] { Store::open_for_writing(file_); });
  g_flock_error = 0;
  EXPECT_EQ(reading, file_.string() + ".lock: No locks available");
  EXPECT_EQ(writing, file_.string() + ".lock: No locks available");
}

// ------------------------------------------------------------------------------------------- what takes its time

/// A reader of a store at rest may check it for minutes.
TEST_F(StoreSharingTest, WriterWaitsForAReaderAndSaysSo) {
  Store reader = Store::open_for_reading(file_);
  auto snapshot = std::make_unique<sqlite::ReadSnapshot>(reader.database());
  EXPECT_EQ(reader.cell_count(), 60);
  const std::string refusal = input_error(
      [&] { Store::open_for_writing(file_, {.tell_after = milliseconds(0), .reader_patience = milliseconds(100)}); });
  EXPECT_TRUE(contains(refusal, file_.string() + ": another process has been reading this store for ")) << refusal;
  EXPECT_TRUE(contains(refusal, " s; try again when it has ended")) << refusal;
  std::vector<std::string> waits;
  const Waiting waiting{.tell =
                            [&](const std::string& line) {
                              if (!contains(line, "waiting")) return;
                              waits.push_back(line);
                              snapshot.reset();
                            },
                        .tell_after = milliseconds(0)};
  { const Store writer = Store::open_for_writing(file_, waiting); }
  EXPECT_EQ(waits, std::vector<std::string>{"waiting for another process that reads " + file_.string()});
  EXPECT_EQ(checked_rows(file_), before_);
}

TEST_F(StoreSharingTest, TheCheckOfALargeStoreIsAnnounced) {
  std::vector<std::string> lines;
  const auto tell = [&](const std::string& line) { lines.push_back(line); };
  Store store = Store::open_for_reading(file_);
  store.check({.tell = tell});
  EXPECT_TRUE(lines.empty());
  store.check({.tell = tell, .tell_bytes = fs::file_size(file_)});
  EXPECT_EQ(lines, std::vector<std::string>{"reading and checking every row of " + file_.string()});
}

TEST_F(StoreSharingTest, SymbolicLinksAreFollowed) {
  fill(folder_ / "more.db", 15);
  fs::create_directory(folder_ / "elsewhere");
  fs::create_symlink("elsewhere/out.db", folder_ / "link.db");  // leads nowhere yet
  merge_stores(folder_ / "link.db", {file_});
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.db"));
  EXPECT_EQ(checked_rows(folder_ / "elsewhere/out.db"), before_);
  merge_stores(folder_ / "link.db", {folder_ / "more.db"});
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.db"));
  EXPECT_EQ(Store::open_for_reading(folder_ / "elsewhere/out.db").cell_count(), 120);
  Store::remove(folder_ / "link.db");
  EXPECT_FALSE(fs::exists(folder_ / "elsewhere/out.db"));
  { const Store store = Store::open_for_writing(folder_ / "link.db"); }
  EXPECT_TRUE(fs::exists(folder_ / "elsewhere/out.db"));
}

}  // namespace
}  // namespace lcpbench
