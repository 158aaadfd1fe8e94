// What a capture leaves in its folder when an engine crashes, when it is interrupted, and beside an old file.
#include <string>

#include "tests/adapters/capture_folder.h"

namespace lcpbench::capture_files_test {
namespace {

/// An engine that crashes ends itself alone, and the steps it wrote are kept.
TEST_F(Capture, KeepsTheStepsOfAnEngineThatCrashes) {
  stand_in("echo 'out of luck' >&2\nkill -SEGV $$");
  EXPECT_EQ(capture_stand_in("crash.scenes"), 1);
  EXPECT_NE(read_file(folder_ / "err").find("killed by signal 11 (SIGSEGV): out of luck"), std::string::npos);
  expect_step_three("crash.scenes");
}

constexpr const char* kInterrupt =
    "& program=$!; until [ -e ready ]; do sleep 0.02; done; kill -TERM $program; wait $program";

TEST_F(Capture, KeepsTheStepsUntilAnInterrupt) {
  stand_in("touch ready\nexec sleep 100");
  EXPECT_EQ(capture_stand_in("stopped.scenes", "", kInterrupt), 3);
  EXPECT_NE(read_file(folder_ / "err").find("stopped.scenes holds the steps until then"), std::string::npos)
      << read_file(folder_ / "err");
  expect_step_three("stopped.scenes");
}

TEST_F(Capture, SaysWhyThereIsNoStep) {
  stand_in(": > \"$5\"");
  EXPECT_EQ(capture_stand_in("none.scenes"), 1);
  EXPECT_NE(read_file(folder_ / "err").find("captured: none of the steps that were looked at has a contact"),
            std::string::npos)
      << read_file(folder_ / "err");
  EXPECT_FALSE(fs::exists(folder_ / "none.scenes"));
}

TEST_F(Capture, ACaptureThatFailsLeavesTheOldFile) {
  std::ofstream(folder_ / "old.scenes") << "old";
  for (const auto& [commands, code] :
       {std::pair{"> \"$5\"", 1}, std::pair{"echo 'bad model' >&2\nexit 2", 2}}) {
    stand_in(commands);
    EXPECT_EQ(capture_stand_in("old.scenes"), code);
    EXPECT_EQ(read_file(folder_ / "old.scenes"), "old");
    expect_no_other_file("old.scenes");
  }
}

/// Neither the steps nor the file that stands there are lost.
TEST_F(Capture, StepsOfACaptureThatDidNotEndAreKeptBesideAnOldFile) {
  std::ofstream(folder_ / "old.scenes") << "old";
  stand_in("touch ready\nexec sleep 100");
  EXPECT_EQ(capture_stand_in("old.scenes", "", kInterrupt), 3);
  EXPECT_EQ(read_file(folder_ / "old.scenes"), "old");
  EXPECT_EQ(ScenesFile((folder_ / "old.incomplete.scenes").string()).step_number(0), 3);
  EXPECT_NE(read_file(folder_ / "err").find("old.incomplete.scenes holds the steps until then\nlcpbench: old.scenes is "
                                            "as it was\n"),
            std::string::npos)
      << read_file(folder_ / "err");
  EXPECT_NE(read_file(folder_ / "out").find("lcpbench solve 'old.incomplete.scenes#3'"), std::string::npos);
}

TEST_F(Capture, AnEngineEndsWithACommandThatIsKilled) {
  stand_in("echo $$ > ready\nexec sleep 1000");
  capture_stand_in("killed.scenes", "", "& until [ -s ready ]; do sleep 0.02; done; kill -KILL $!");
  EXPECT_FALSE(runs_on(folder_ / "ready"));
  fs::remove(folder_ / "killed.scenes.part");  // empty; the next capture uses it again
  expect_no_other_file("");
}

TEST_F(Capture, ASecondCommandWithTheSameOutputIsRefused) {
  stand_in("touch ready\nexec sleep 100");
  EXPECT_EQ(capture_stand_in("one.scenes", "",
                             "& program=$!; until [ -e ready ]; do sleep 0.02; done; '" LCPBENCH_PROGRAM
                             "' capture stack --out one.scenes 2>second; code=$?; kill -TERM $program; wait; "
                             "exit $code"),
            2);
  EXPECT_EQ(read_file(folder_ / "second"),
            "lcpbench: one.scenes: cannot be written: another process is writing it\n");
  expect_step_three("one.scenes");
}

/// What is printed to be typed again names the same file, in one line.
TEST_F(Capture, ThePrintedCommandNamesAnyFile) {
  for (const std::string word : {"-o.scenes", "$'a b\\033[2J\\n.scenes'"}) {
    stand_in("");
    std::ofstream(folder_ / "script") << "export LCPBENCH_WORKER_DIR='" << folder_.string() << "'\n'" LCPBENCH_PROGRAM
                                      << "' capture stack --out=" << word << " >out 2>err";
    const std::string bash = "cd '" + folder_.string() + "' && bash script";
    ASSERT_EQ(std::system(bash.c_str()), 0) << read_file(folder_ / "err");
    const std::string out = read_file(folder_ / "out");
    EXPECT_EQ(std::count(out.begin(), out.end(), '\n'), 3) << out;
    EXPECT_EQ(out.find('\x1b'), std::string::npos);
    const std::string printed = "lcpbench solve ";
    std::ofstream(folder_ / "script") << "'" LCPBENCH_PROGRAM "' inspect "
                                      << out.substr(out.find(printed) + printed.size());
    EXPECT_EQ(std::system((bash + " 2>err >out").c_str()), 0) << out << read_file(folder_ / "err");
  }
}

}  // namespace
}  // namespace lcpbench::capture_files_test
