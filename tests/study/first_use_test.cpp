// What a new user meets: what was asked for is done or said to be left out, the reason of a failure stands on a narrow
// screen, and the last lines say what the table says.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "study/output/text_table.h"
#include "study/store/store.h"
#include "tests/support/program_run.h"
#include "tests/support/study_support.h"

namespace lcpbench::first_use_test {
namespace {

constexpr const char* kBall =
    R"({"format": "lcpbench-problem", "version": 1, "name": "ball", "kind": "scene", "bodies": [{"mass": 1,)"
    R"("inertia": [[0.004, 0, 0], [0, 0.004, 0], [0, 0, 0.004]], "position": [0, 0, 0.1],)"
    R"("linear_velocity": [0.3, 0, -1], "angular_velocity": [0, 0, 0]}], "contacts": [{"body_a": 0, "body_b": -1,)"
    R"("point": [0, 0, 0], "normal": [0, 0, 1], "tangent": [1, 0, 0], "mu": 0.5, "edges": 4}]})";

class FirstUseTest : public ::testing::Test {
 protected:
  FirstUseTest() { std::ofstream(folder_ / "ball.json") << kBall; }
  void SetUp() override { setenv("COLUMNS", "80", 1); }
  void TearDown() override { unsetenv("COLUMNS"); }
  ProgramRun run(const std::string& arguments) { return run_program(folder_ / "", arguments); }

  /// A program for `external` that answers so many questions, says its last words, and ends.
  void write_program(const std::string& name, int answers, const std::string& last_words) {
    std::ofstream program(folder_ / name);
    program << "#!/bin/sh\n";
    for (int i = 1; i <= answers; ++i) program << "read line; echo '{\"sequence\": " << i << "}'\n";
    program << "read line; echo '" << last_words << "' >&2; exit 3\n";
    program.close();
    std::filesystem::permissions(folder_ / name, std::filesystem::perms::owner_all);
  }

  ScratchFolder folder_;
};

/// The text with every line break as a blank.
std::string unfolded(const std::string& text) {
  std::istringstream words(text);
  std::string result;
  for (std::string word; words >> word;) result += (result.empty() ? "" : " ") + word;
  return result;
}

bool has(const std::string& text, const std::string& part) { return unfolded(text).find(part) != std::string::npos; }

TEST_F(FirstUseTest, OfAFileAllProblemsAreTaken) {
  std::ofstream scenes(folder_ / "long.scenes");
  scenes << R"({"format":"lcpbench-scenes","version":1,"scene":"s"})" << "\n";
  for (int step = 0; step < 130; ++step) {
    scenes << R"({"step":)" << step
           << R"(,"problem":{"format":"lcpbench-problem","version":1,"name":"p","kind":"contact","v":[-1],)"
           << R"("N":{"starts":[0,1],"rows":[0],"values":[1]},"G_blocks":[[[)" << step + 1 << "]]]}}\n";
  }
  scenes.close();
  const ProgramRun part = run("run --set file:long.scenes --solver lemke --trials 20 --store long.db");
  EXPECT_EQ(part.exit_code, 0) << part.err;
  EXPECT_TRUE(has(part.err, "file:long.scenes: the first 20 of its 130 problems are taken; --trials 130 takes all"))
      << part.err;
  const ProgramRun all = run("run --set file:long.scenes --set paper/monotone/exp1 --solver lemke --store long.db");
  EXPECT_EQ(all.exit_code, 0) << all.err;
  EXPECT_EQ(all.err.find("are taken"), std::string::npos) << all.err;
  EXPECT_EQ(Store::open_for_reading(folder_ / "long.db").cell_count(), 130 + 100);
  for (const char* command : {"stability", "validate"}) {
    const ProgramRun some = run(std::string(command) + " --set file:long.scenes --solver lemke --trials 2");
    EXPECT_TRUE(has(some.err, "the first 2 of its 130 problems are taken")) << command << ": " << some.err;
  }
  const ProgramRun sets = run("run --set 'scene/stack/*' --solver lemke --trials 1 --store s.db");
  EXPECT_TRUE(has(sets.err, "the first ones of each")) << sets.err;
}

TEST_F(FirstUseTest, TheReasonOfAFailingProgramStandsOnANarrowScreen) {
  write_program("fails.sh", 3, "my matrix is singular");
  const ProgramRun text = run("solve ball.json --solver 'external{command=./fails.sh}' --solver lemke");
  EXPECT_EQ(text.exit_code, 1);
  EXPECT_TRUE(has(text.out, "ended with crashed (solve: exited with code 3 without an answer; stderr: my matrix is "
                            "singular); the problem has a solution"))
      << text.out;
  EXPECT_EQ(run("solve ball.json --solver 'external{command=./fails.sh}' --format json").exit_code, 1);
  // A program that does not start at all is bad input; an honest failure is a result.
  write_program("mute.sh", 0, "no start");
  EXPECT_EQ(run("solve ball.json --solver 'external{command=./mute.sh}' --solver lemke").exit_code, 2);
  const ProgramRun honest = run("solve ball.json --solver 'psor{max_iterations=1}' --solver lemke");
  EXPECT_EQ(honest.exit_code, 0);
  EXPECT_TRUE(has(honest.out, "missed")) << honest.out;
}

/// Mine first, by its name; the sentences are those of the solvers that were named.
TEST_F(FirstUseTest, NamedSolversStandInTheirOrderAndTheSentencesAreTheirs) {
  write_program("fails.sh", 3, "my matrix is singular");
  const std::string mine = "'external{command=./fails.sh,name=mine}'";
  const ProgramRun text = run("solve ball.json --solver " + mine + " --solver lemke");
  const std::size_t first = text.out.find("\nmine ");
  ASSERT_NE(first, std::string::npos) << text.out;
  EXPECT_LT(first, text.out.find("\nlemke ")) << text.out;
  EXPECT_TRUE(has(text.out, "mine ended with crashed")) << text.out;
  const ProgramRun all = run("solve ball.json");
  EXPECT_FALSE(has(all.out, " refused the problem")) << all.out;
  EXPECT_FALSE(has(all.out, " ended with ")) << all.out;
}

double seconds_of(const std::string& number, const std::string& unit) {
  const std::map<std::string, double> units{{"ns", 1e-9}, {"µs", 1e-6}, {"ms", 1e-3}, {"s", 1}};
  return std::stod(number) * units.at(unit);
}

TEST_F(FirstUseTest, TheLastLinesOfSolveSayWhatTheTableSays) {
  const ProgramRun output = run("solve ball.json");
  ASSERT_EQ(output.exit_code, 0) << output.err;
  std::istringstream lines(output.out);
  std::map<std::string, std::vector<double>> times;  // of each verdict, in the order of the rows
  std::string first_time;
  bool in_table = false;
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(character_count(line), 80U) << line;
    std::istringstream words(line);
    const std::vector<std::string> cells{std::istream_iterator<std::string>(words), {}};
    if (line.starts_with("---")) in_table = true;
    if (!in_table || line.starts_with("---")) continue;
    if (line.find("left out") != std::string::npos) break;
    ASSERT_GE(cells.size(), 5U) << line;
    if (cells.back() == "-") continue;
    const std::string& unit = cells.back();
    const std::string& number = cells[cells.size() - 2];
    if (first_time.empty()) first_time = number + " " + unit;
    times[cells[2]].push_back(seconds_of(number, unit));
  }
  EXPECT_GT(times["solved"].size(), 3U) << output.out;
  for (const auto& [verdict, each] : times) {
    EXPECT_TRUE(std::is_sorted(each.begin(), each.end())) << verdict << "\n" << output.out;
  }
  EXPECT_TRUE(has(output.out, ": " + first_time)) << first_time << "\n" << output.out;
}

TEST_F(FirstUseTest, CertifySaysWhatItLeftOut) {
  ASSERT_EQ(run("run --set paper/copositive/exp1 --trials 22 --solver contact_lemke --store f.db").exit_code, 0);
  const ProgramRun some = run("certify --store f.db");
  EXPECT_EQ(some.exit_code, 0) << some.err;
  EXPECT_TRUE(has(some.out, "20 problems with friction were left out, because --every 20 takes only one trial in 20 of "
                            "them. --every 1 takes all"))
      << some.out;
  const ProgramRun all = run("certify --store f.db --every 1 --format json");
  EXPECT_EQ(all.err.find("left out"), std::string::npos) << all.err;
  EXPECT_TRUE(has(all.err, "Of 22 problems with a certificate 22 have a solution, 0 have none, and 0 are open."))
      << all.err;
}

}  // namespace
}  // namespace lcpbench::first_use_test
