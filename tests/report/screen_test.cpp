// What the screen says of a user's own capture: who solves it, what so few steps show, whose step it is, and the worst
// step of each solver with a command that repeats it.

#include <cstdlib>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/scenes_file.h"
#include "study/inspect/rigid_bodies.h"
#include "tests/support/program_run.h"
#include "tests/support/study_support.h"

namespace lcpbench::screen_test {
namespace {

constexpr const char* kSwept = "'psor{max_iterations=1}'";

/// Three contacts without friction on these coordinates, which approach faster from step to step.
Problem made_step(Inertia inertia, int step) {
  const Index ngc = dimension(inertia);
  ContactProblem contact{.v = Vector::Constant(ngc, -1 - 0.01 * step), .edges = {0, 0, 0}, .mu = Vector::Zero(3)};
  Matrix N = Matrix::Zero(ngc, 3);
  for (Index i = 0; i < 3; ++i) N(i, i) = N((i + 1) % 3, i) = 1;
  contact.N = N;
  contact.D = Matrix(ngc, 0);
  contact.inertia = std::move(inertia);
  return {"made", std::move(contact)};
}

/// Seven joints that move each other.
Inertia robot() { return BlockInertia{{Matrix(Matrix::Identity(7, 7) + Matrix::Constant(7, 7, 0.5))}}; }

Matrix bodies(Index count) {
  Vector diagonal(6 * count);
  for (Index i = 0; i < count; ++i) diagonal.segment(6 * i, 6) << 2, 2, 2, 0.1, 0.2, 0.25;
  Matrix G = diagonal.asDiagonal();
  for (Index i = 0; i < count; ++i) G(6 * i + 3, 6 * i + 4) = G(6 * i + 4, 6 * i + 3) = 0.05;
  return G;
}

class ScreenTest : public ::testing::Test {
 protected:
  ScreenTest() { setenv("COLUMNS", "1000", 1); }
  void TearDown() override { unsetenv("COLUMNS"); }

  /// Every tenth step; the engine's own answer does nothing.
  void write(const std::string& engine, const Inertia& inertia, int steps, int every = 10) {
    ScenesWriter writer((folder_ / "x.scenes").string(), {.scene = "made", .engine = engine, .engine_version = "0.1"});
    for (int i = 0; i < steps; ++i) {
      SceneStep step{.step = every * i, .problem = made_step(inertia, i)};
      step.engine_impulses = Vector::Zero(3);
      writer.add(step);
    }
    writer.close();
  }
  std::string run(const std::string& arguments) {
    const ProgramRun ended = run_program(folder_ / "", arguments);
    EXPECT_EQ(ended.exit_code, 0) << arguments << "\n" << ended.err;
    return ended.out;
  }
  /// Runs a printed command, as a user pastes it. @returns what its last part prints
  std::string paste(std::string command) {
    std::string out;
    for (std::size_t end = 0; end != std::string::npos; command.erase(0, end == std::string::npos ? 0 : end + 4)) {
      end = command.find(" && ");
      const std::string part = command.substr(0, end);
      EXPECT_EQ(part.rfind("lcpbench ", 0), 0U) << part;
      out = run(part.substr(9) + (end == std::string::npos ? " --format json" : ""));
    }
    return out;
  }
  static std::vector<std::string> commands_of(const std::string& text) {
    std::vector<std::string> commands;
    const std::regex line("\n  (lcpbench [^\n]*?)(  # [^\n]*)?(?=\n)");
    for (std::sregex_iterator it(text.begin(), text.end(), line), end; it != end; ++it) commands.push_back((*it)[1]);
    return commands;
  }
  ScratchFolder folder_;
};

TEST_F(ScreenTest, AStepIsARobotsByItsInertiaWhoeverCapturedIt) {
  const Inertia fingers = BlockInertia{{Matrix(Matrix::Identity(2, 2) + Matrix::Constant(2, 2, 0.5)), bodies(1)}};
  for (const Inertia& inertia : {robot(), Inertia(DenseInertia{std::get<BlockInertia>(robot()).blocks[0]}), fingers}) {
    EXPECT_FALSE(has_free_bodies(made_step(inertia, 0)));
  }
  const Inertia planar = BlockInertia{{Matrix(Vector::Constant(3, 2.0).asDiagonal())}};
  const Inertia blocks = BlockInertia{{bodies(1), bodies(1)}};
  const Inertia mixed = BlockInertia{{bodies(1), Matrix(Vector::Constant(3, 2.0).asDiagonal())}};  // and a particle
  for (const Inertia& inertia : {blocks, Inertia(DenseInertia{bodies(2)}), planar, mixed}) {
    EXPECT_TRUE(has_free_bodies(made_step(inertia, 0)));
  }
  write("my engine", robot(), 3);
  const std::string study = "run --set file:x.scenes --solver auto --solver contact_lemke --fresh";
  EXPECT_NE(run(study).find("A robot's step"), std::string::npos);
  write("my engine", DenseInertia{bodies(1)}, 3);
  EXPECT_NE(run(study).find("Other scenes"), std::string::npos);
}

TEST_F(ScreenTest, ASmallCaptureSaysWhatItShowsAndWhatToAdd) {
  write("my engine", robot(), 30);
  const std::string out = run("run --set file:x.scenes --solver auto --solver contact_lemke");
  EXPECT_TRUE(std::regex_search(
      out, std::regex("A robot's step: too few to say: 30 problems; the report needs 35; capture --every 5 gives 60 "
                      "steps; the best by share solved, \\w+, solved 100 % \\(88.6–100 %\\) of 30 problems\n")))
      << out;
  EXPECT_EQ(out.find("no solver is shown"), std::string::npos);
  EXPECT_EQ(out.find("worst problem"), std::string::npos) << "nobody fails";
}

TEST_F(ScreenTest, RunNamesTheWorstStepsWithCommandsThatRepeatThem) {
  write("my engine", robot(), 4);
  const std::string out =
      run(std::string("run --set file:x.scenes --set paper/copositive/exp1 --trials 4 --store a.db ") +
          "--solver auto --solver engine --solver " + kSwept);
  const std::vector<std::string> commands = commands_of(out);
  ASSERT_EQ(commands.size(), 2U) << out;
  EXPECT_EQ(commands[0].rfind("lcpbench solve 'x.scenes#", 0), 0U) << "a false claim comes first: " << out;
  EXPECT_EQ(nlohmann::json::parse(paste(commands[0]))[0]["verdict"], "wrong") << commands[0];
  EXPECT_EQ(nlohmann::json::parse(paste(commands[1]))[0]["verdict"], "missed") << commands[1];
  EXPECT_NE(out.find(commands[0] + "  # wrong by "), std::string::npos) << out;
  EXPECT_NE(out.find("said solved, and was wrong: my engine 0.1 on 4 of 4"), std::string::npos) << out;

  run("report a.db --out r");
  std::istringstream table(read_file(folder_ / "r/tables/results.csv"));
  int replayed = 0;
  for (std::string line; std::getline(table, line);) {
    const std::size_t at = line.find("lcpbench ");
    if (at == std::string::npos) continue;
    ++replayed;
    EXPECT_NE(nlohmann::json::parse(paste(line.substr(at)))[0]["verdict"], "solved") << line;
  }
  EXPECT_EQ(replayed, 3) << "engine on the steps, the other solver on both sets";
  EXPECT_NE(table.str().find("\nfile:x.scenes,my engine 0.1,"), std::string::npos) << table.str();
}

/// An answer that started from the one before depends on all steps before it.
TEST_F(ScreenTest, TheWorstStepFromTheLastAnswerHasACommandThatRepeatsIt) {
  write("my engine", robot(), 5, 1);
  run(std::string("run --set file:x.scenes --start last --store a.db --solver ") + kSwept);
  std::ofstream(folder_ / "worst.sql") << "SELECT trial, error, command FROM worst WHERE solver LIKE '%start=last}' "
                                          "AND place = 1";
  const auto worst = nlohmann::json::parse(run("query a.db worst.sql --format json"))[0];
  run(worst["command"].get<std::string>().substr(std::string("lcpbench ").size()));
  std::ofstream(folder_ / "again.sql")
      << "SELECT verdict, velocity_residual_relative AS error FROM judged JOIN verdicts "
         "USING (problem_id, solver_id, part) JOIN solvers ON id = solver_id "
         "WHERE settings LIKE '%start=last' AND trial = "
      << worst["trial"];
  const auto again = nlohmann::json::parse(run("query again.db again.sql --format json"));
  ASSERT_EQ(again.size(), 1U) << worst;
  EXPECT_NE(again[0]["verdict"], "solved");
  EXPECT_EQ(again[0]["error"], worst["error"]);
}

TEST_F(ScreenTest, AWrongAnswerIsRedOnATerminalAlone) {
  if (std::system("script -qec true /dev/null </dev/null >/dev/null 2>&1") != 0) GTEST_SKIP() << "no pseudo-terminal";
  write("mine", robot(), 1);
  const std::string solve = "solve 'x.scenes#0' --solver engine";
  const std::string command = "cd '" + (folder_ / "").string() + "' && env -u NO_COLOR script -qec \"'" LCPBENCH_PROGRAM
                              "' " + solve + "\" /dev/null </dev/null >screen";
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
  EXPECT_NE(read_file(folder_ / "screen").find("  \033[31mwrong\033[0m "), std::string::npos);
  EXPECT_EQ(run(solve).find('\033'), std::string::npos);
}

TEST_F(ScreenTest, SolveEndsWithOneTotalThatNamesTheWorstSteps) {
  write("my engine", robot(), 4);
  const std::string out = run("solve x.scenes --solver auto --solver engine --solver " + std::string(kSwept));
  const std::string total = out.substr(std::min(out.rfind("4 problems"), out.size()));
  EXPECT_TRUE(std::regex_search(total, std::regex("\nauto +4 +0 +0 +0 "))) << out;
  EXPECT_TRUE(std::regex_search(total, std::regex("\nmy engine 0\\.1 +0 +0 +4 +0 +0 "))) << out;
  EXPECT_TRUE(std::regex_search(total, std::regex("\npsor\\{max_iterations=1\\} +0 +0 +0 +4 +0 "))) << out;
  const std::vector<std::string> commands = commands_of(total);
  ASSERT_EQ(commands.size(), 2U) << total;
  EXPECT_EQ(nlohmann::json::parse(paste(commands[1]))[0]["verdict"], "wrong") << commands[1];
  EXPECT_EQ(run("solve 'x.scenes#10' --solver auto").find("4 problems"), std::string::npos);
}

TEST_F(ScreenTest, OfASoftEngineTheScreenSaysThatItSolvesAnotherProblem) {
  constexpr const char* kWords = " on purpose: its";
  for (const char* engine : {"MuJoCo", "Bullet", "my engine"}) {
    const bool soft = std::string(engine) != "my engine";
    write(engine, robot(), 2);
    for (const char* command : {"solve x.scenes --solver engine", "solve 'x.scenes#10' --solver engine",
                                "run --set file:x.scenes --solver engine --fresh --store m.db"}) {
      EXPECT_EQ(run(command).find(kWords) != std::string::npos, soft) << command;
    }
    run("report m.db --out r");
    EXPECT_EQ(read_file(folder_ / "r/report.html").find(kWords) != std::string::npos, soft);
  }
}

}  // namespace
}  // namespace lcpbench::screen_test
