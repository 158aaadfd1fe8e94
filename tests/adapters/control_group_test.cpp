// The limits on a program together with all that it starts, where the system has groups for that.

#include "adapters/worker/control_group.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "adapters/external/external_program.h"
#include "core/error.h"
#include "tests/adapters/external_client.h"

namespace lcpbench {
namespace {

/// Every group has this limit, also where memory and processes are limited by the older kind of groups.
/// @returns false when not even such a group can be made here
bool make_any_group() { return worker::make_control_group(worker::group_folders(), {{"cgroup.max.descendants", "0"}}); }

std::filesystem::path own_group() {
  for (const std::filesystem::path& folder : worker::group_folders()) {
    const std::filesystem::path group = folder / ("lcpbench-" + std::to_string(getpid()));
    if (std::filesystem::exists(group)) return group;
  }
  return {};
}

TEST(ControlGroupTest, ProgramsAreInTheGroupThatWasMadeForThem) {
  if (!make_any_group()) GTEST_SKIP() << "no control group can be made here";
  {
    external::ExternalProgram program(
        external::command_words("sh -c 'read line; tr \"\\\\n\" \" \" < /proc/self/cgroup; echo'"));
    const std::string groups = program.ask("{}", 10000, wall_clock_s() + 20.0);
    EXPECT_NE(groups.find("lcpbench-" + std::to_string(getpid())), std::string::npos) << groups;
  }
  worker::remove_control_group();
  for (const std::filesystem::path& folder : worker::group_folders()) {
    EXPECT_FALSE(std::filesystem::exists(folder / ("lcpbench-" + std::to_string(getpid()))));
  }
}

TEST(ControlGroupTest, ProgramThatCannotBePutIntoItsGroupIsNotRun) {
  if (!make_any_group()) GTEST_SKIP() << "no control group can be made here";
  std::filesystem::remove(own_group());  // as an administrator might
  try {
    external::ExternalProgram program(external::command_words("cat"));
    ADD_FAILURE() << "it runs without its limits";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "external: cannot put cat under its limits, a control group: No such file or directory");
  }
  worker::remove_control_group();
}

TEST(ControlGroupTest, LimitWithoutAFileIsAnErrorOnlyWhereItIsNeeded) {
  const worker::GroupLimit any{"cgroup.max.descendants", "0"};
  if (!make_any_group()) GTEST_SKIP() << "no control group can be made here";
  worker::remove_control_group();
  EXPECT_FALSE(worker::make_control_group(worker::group_folders(), {any, {"no.such.file", "0"}}));
  EXPECT_TRUE(worker::make_control_group(worker::group_folders(),
                                         {any, {.file = "no.such.file", .value = "0", .needed = false}}));
  worker::remove_control_group();
}

/// Writes a program of the user's into the folder. @returns its name
std::string python_program(const Scratch& scratch, const std::string& text) {
  const std::string file = scratch.file("program.py");
  std::ofstream(file) << "#!/usr/bin/env -S python3 -I -S\nimport os, sys, time\nsys.stdin.readline()\n"
                      << text << "print(result, flush=True)\n";
  std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  return file;
}

int result_of(const std::string& program) {
  return std::stoi(external::ExternalProgram({program}).ask("{}", 100, wall_clock_s() + 60.0));
}

// Each of two children may have half a group's memory and more; both together may not, swap included.
TEST(ControlGroupTest, MemoryIsLimitedForAllProcessesTogether) {
  const Scratch scratch;
  const std::string program = python_program(scratch, R"(
children = []
for i in range(2):
    children.append(os.fork())
    if children[-1] == 0:
        kept = b"x" * (100 << 20)
        time.sleep(1)
        os._exit(0)
result = sum(os.waitpid(child, 0)[1] == 0 for child in children)
)");
  EXPECT_EQ(result_of(program), 2) << "without a limit";
  if (!worker::make_control_group(worker::group_folders(), worker::group_limits(std::uint64_t{150} << 20))) {
    GTEST_SKIP() << "no control group with memory and processes can be made here";
  }
  EXPECT_LT(result_of(program), 2);
  worker::remove_control_group();
}

TEST(ControlGroupTest, NumberOfProcessesIsLimited) {
  const Scratch scratch;
  const std::string program = python_program(scratch, R"(
children = []
try:
    while len(children) < 600:
        children.append(os.fork())
        if children[-1] == 0:
            time.sleep(100)
            os._exit(0)
except OSError:
    pass
result = len(children)
for child in children:
    os.kill(child, 9)
    os.waitpid(child, 0)
)");
  if (!worker::make_control_group(worker::group_folders(), worker::group_limits(std::uint64_t{1} << 32))) {
    GTEST_SKIP() << "no control group with memory and processes can be made here";
  }
  EXPECT_EQ(result_of(program), worker::kGroupProcesses - 1);
  worker::remove_control_group();
}

TEST(ControlGroupTest, NothingIsLeftWhereNoneCanBeMade) {
  const Scratch scratch;
  const std::filesystem::path folder = std::filesystem::path(scratch.file("x")).parent_path();
  EXPECT_FALSE(worker::make_control_group({folder, folder / "missing"}, worker::group_limits(1 << 30)));
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  EXPECT_TRUE(worker::join_control_group()) << "there is none to join";
}

}  // namespace
}  // namespace lcpbench
