// Files that are written whole or not at all.

#include "core/io/whole_file.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/error.h"
#include "tests/support/program_run.h"

namespace lcpbench::whole_file_test {
namespace {

namespace fs = std::filesystem;

class WholeFileTest : public ::testing::Test {
 protected:
  WholeFileTest() : folder_(fs::temp_directory_path() / ("lcpbench-whole-" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
    std::ofstream(file_) << "old";
  }
  ~WholeFileTest() override { fs::remove_all(folder_); }

  static std::string refusal(const fs::path& file) {
    try {
      const WholeFile refused(file);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  fs::path folder_;
  fs::path file_ = folder_ / "f.txt";
  fs::path draft_ = folder_ / "f.txt.part";
};

TEST_F(WholeFileTest, WhatStoodThereStaysUntilAllIsWritten) {
  chmod(file_.c_str(), 0640);
  {
    WholeFile file(file_);
    file.write("new");
    EXPECT_EQ(file.draft(), draft_);
    EXPECT_TRUE(file.had_content());
    EXPECT_EQ(read_file(file_), "old");
  }
  EXPECT_EQ(read_file(file_), "old");
  EXPECT_FALSE(fs::exists(draft_));
  write_file(file_, "new");
  EXPECT_EQ(read_file(file_), "new");
  EXPECT_FALSE(fs::exists(draft_));
  EXPECT_EQ(fs::status(file_).permissions(), fs::perms(0640));
}

TEST_F(WholeFileTest, ASecondWriterIsRefusedAndAKilledOnesDraftIsUsedAgain) {
  {
    WholeFile file(file_);
    EXPECT_EQ(refusal(file_), file_.string() + ": cannot be written: another process is writing it");
    file.write("new");
    file.commit();
  }
  EXPECT_EQ(read_file(file_), "new");
  std::ofstream(draft_) << "what a killed process left";
  WholeFile file(file_);
  EXPECT_EQ(read_file(draft_), "");
  file.write("newer");
  file.commit();
  EXPECT_EQ(read_file(file_), "newer");
  EXPECT_FALSE(fs::exists(draft_));
}

TEST_F(WholeFileTest, LinksAreFollowedAndDevicesAreWrittenInPlace) {
  fs::create_symlink("f.txt", folder_ / "link");
  fs::create_symlink("none.txt", folder_ / "dangling");
  write_file(folder_ / "link", "by the link");
  write_file(folder_ / "dangling", "by the link");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(read_file(file_), "by the link");
  EXPECT_EQ(read_file(folder_ / "none.txt"), "by the link");
  write_file("/dev/null", "nothing");
  EXPECT_FALSE(fs::exists("/dev/null.part"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(WholeFileTest, WhatCannotBeWrittenIsNamed) {
  EXPECT_EQ(refusal(folder_), folder_.string() + ": cannot be written: is a folder");
  const fs::path nowhere = folder_ / "none/f.txt";
  EXPECT_EQ(refusal(nowhere), nowhere.string() + ": cannot be written: No such file or directory");
  EXPECT_THROW(write_file("/dev/full", "x"), InputError);
}

}  // namespace
}  // namespace lcpbench::whole_file_test
