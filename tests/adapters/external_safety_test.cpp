// No process of a user's program outlives the solver, or lcpbench, however that ends; and what
// docs/reference/external.md promises.

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/prctl.h>
#include <unistd.h>

#include "core/io/problem_io.h"
#include "tests/adapters/external_client.h"

namespace lcpbench {
namespace {

TEST(ExternalSafetyTest, NothingOutlivesTheSolver) {
  prctl(PR_SET_CHILD_SUBREAPER, 1);  // an orphan becomes ours, and can be waited for
  {
    const auto solver = client();
    EXPECT_STREQ(to_string(run(*solver, "fork").claim), "solved");
    run(*solver, "sleep", kImpatient);
    EXPECT_STREQ(to_string(run(*solver, "fork").claim), "solved");
    const auto behind_a_shell = client("sh -c '" EXTERNAL_FAULTS "; true'");
    expect_right(*behind_a_shell);
  }
  EXPECT_TRUE(all_children_end_within(60.0));
  prctl(PR_SET_CHILD_SUBREAPER, 0);
}

bool has_ended(pid_t process) { return state_of(process) == '?' || state_of(process) == 'Z'; }

bool ends_within(double seconds, pid_t process) {
  const double deadline_s = wall_clock_s() + seconds;
  while (!has_ended(process) && wall_clock_s() < deadline_s) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  if (has_ended(process)) return true;
  kill(process, SIGKILL);
  return false;
}

TEST(ExternalSafetyTest, DaemonsEndWithTheSolver) {
  pid_t daemon = 0;
  {
    const auto solver = client();
    daemon = static_cast<pid_t>(run(*solver, "daemon").counters.iterations);
    ASSERT_GT(daemon, 0);
    expect_right(*solver);
    EXPECT_FALSE(has_ended(daemon)) << "it may live while its program does";
  }
  EXPECT_TRUE(ends_within(60.0, daemon));
}

pid_t start_lcpbench_solve(const std::string& problem, const std::string& solver) {
  const pid_t program = fork();
  if (program != 0) return program;
  execl(LCPBENCH_PROGRAM, LCPBENCH_PROGRAM, "solve", problem.c_str(), "--time-limit", "1000", "--solver",
        solver.c_str(), nullptr);
  _exit(127);
}

bool has_great_grandchild(pid_t program) {
  for (const pid_t worker : children_of(program)) {
    for (const pid_t shell : children_of(worker)) {
      if (!children_of(shell).empty()) return true;
    }
  }
  return false;
}

TEST(ExternalSafetyTest, KillOfLcpbenchEndsProgramAndChildren) {
  const Scratch scratch;
  write_problem(named("sleep"), scratch.file("sleep.json"));
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  const pid_t program =
      start_lcpbench_solve(scratch.file("sleep.json"), "external{command=sh -c '" EXTERNAL_FAULTS "; true'}");
  for (int i = 0; i < 6000 && !has_great_grandchild(program); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(has_great_grandchild(program));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // it is in its sleep by now
  kill(program, SIGKILL);
  EXPECT_TRUE(all_children_end_within(60.0));
  prctl(PR_SET_CHILD_SUBREAPER, 0);
}

TEST(ExternalSafetyTest, KillOfLcpbenchEndsDaemons) {
  const Scratch scratch;
  write_problem(named("daemon and sleep"), scratch.file("daemon.json"));
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  const pid_t program = start_lcpbench_solve(scratch.file("daemon.json"), "external{command=" EXTERNAL_FAULTS "}");
  const auto has_daemon = [&] {  // beside the program, since the worker adopted it
    for (const pid_t worker : children_of(program)) {
      if (children_of(worker).size() == 2) return true;
    }
    return false;
  };
  for (int i = 0; i < 6000 && !has_daemon(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_TRUE(has_daemon());
  kill(program, SIGKILL);
  EXPECT_TRUE(all_children_end_within(60.0));
  prctl(PR_SET_CHILD_SUBREAPER, 0);
}

/// Standard output of `lcpbench <arguments>`, run in the repository's top folder; "" when it fails.
std::string lcpbench(const std::string& arguments) {
  std::FILE* output = popen(("cd '" REPOSITORY "' && '" LCPBENCH_PROGRAM "' " + arguments).c_str(), "r");
  if (output == nullptr) return {};
  std::string text;
  for (int c = std::fgetc(output); c != EOF; c = std::fgetc(output)) text += static_cast<char>(c);
  return pclose(output) == 0 ? text : "";
}

// What docs/reference/external.md promises, word for word.
constexpr const char* kExample = "--solver 'external{command=examples/external_solver.py}' ";

TEST(ExternalExampleTest, SolvesTheBoxOnTheSlope) {
  const std::string text = lcpbench(std::string("solve examples/box_on_slope.json --format json ") + kExample);
  ASSERT_NE(text, "");
  const nlohmann::json answer = nlohmann::json::parse(text).at(0);
  EXPECT_EQ(answer["claim"], "solved") << answer["detail"];
  EXPECT_EQ(answer["verdict"], "solved");
  EXPECT_EQ(answer["settings"], "command=examples/external_solver.py");
  EXPECT_GT(answer["time"]["solve_s"], 0);
  EXPECT_GT(answer["counters"]["pivots"], 0);
}

TEST(ExternalExampleTest, DoesNotRunWhereNobodyAskedForIt) {
  const Scratch scratch;
  const std::string solved = lcpbench("solve examples/box_on_slope.json");
  EXPECT_NE(solved.find("lemke"), std::string::npos);
  EXPECT_EQ(solved.find("external"), std::string::npos);
  EXPECT_NE(lcpbench("run --set paper/monotone/exp1 --trials 1 --jobs 1 --store " + scratch.file("all.db")), "");
}

TEST(ExternalExampleTest, RunsInAStudy) {
  const Scratch scratch;
  const std::string store = scratch.file("mine.db");
  ASSERT_NE(lcpbench(std::string("run --set paper/monotone/exp1 --set rigid/exp1 --trials 3 --jobs 1 ") + kExample +
                     "--solver lemke --store " + store),
            "");
  ASSERT_NE(lcpbench("report " + store + " --out " + scratch.file("report")), "");
  const nlohmann::json summary = nlohmann::json::parse(std::ifstream(scratch.file("report/summary.json")));
  int cells = 0;
  for (const nlohmann::json& cell : summary["cells"]) {
    if (cell["solver"] != "external") continue;
    ++cells;
    EXPECT_EQ(cell["trials"], 3);
    EXPECT_EQ(cell["solved"], 3) << cell;
    EXPECT_EQ(cell["crashed"], 0);
  }
  EXPECT_EQ(cells, 2);
}

}  // namespace
}  // namespace lcpbench
