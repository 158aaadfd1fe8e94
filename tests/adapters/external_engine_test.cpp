// Engines that are programs of a user's own, played by tests/adapters/balls_engine.py: `capture` and `replay` of
// --engine external{command=...}.
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/adapters/capture_folder.h"
#include "tests/support/program_run.h"

namespace lcpbench::external_engine_test {
namespace {

class ExternalEngine : public Capture {
 protected:
  void SetUp() override {
    const bool there = std::system("/usr/bin/python3 -c 'import numpy' 2>/dev/null") == 0;
    if (!there) GTEST_SKIP() << "python3-numpy is not installed";
  }

  static std::string engine(const std::string& fault = "") {
    const std::string command =
        "/usr/bin/python3 " + (fs::path(REPOSITORY) / "tests/adapters/balls_engine.py").string();
    return "--engine 'external{command=" + command + " " + fault + "}' ";
  }

  ProgramRun bouncing(const std::string& fault = "") const {
    return capture("bouncing-balls " + engine(fault) + "--steps 90 --every 1 --out balls.scenes");
  }
};

/// The stand-in solves its contacts exactly, and the verdict on its answers is right only if masses, inertias, forces,
/// places, normals and offsets of the captured problem are those that it had.
TEST_F(ExternalEngine, CapturesTheProblemThatTheEngineSolved) {
  const ProgramRun run = bouncing();
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const ScenesFile file((folder_ / "balls.scenes").string());
  EXPECT_EQ(file.header().engine, "Balls");
  ASSERT_GE(file.count(), 10U);
  const ProgramRun solved = run_program(folder_, "solve balls.scenes --solver 'engine{model=cone}' --format json");
  std::size_t pushed = 0;
  for (const auto& answer : nlohmann::json::parse(solved.out)) {
    EXPECT_EQ(answer.at("verdict"), "solved") << answer.dump();
    if (answer.at("z").at(0).get<double>() > 0) ++pushed;
  }
  EXPECT_GE(pushed, 3U);
  for (std::size_t i = 0; i < file.count(); ++i) EXPECT_EQ(file.read(i).contact_ids.size(), file.read(i).gap.size());
}

/// A stepper's velocities move the bodies as the engine's own do: the round cone's solution is the same for both, so
/// that balls which bounce on the floor and on each other are at the same places after a quarter of a second.
TEST_F(ExternalEngine, AStepperMovesTheBodies) {
  for (const char* loop : {"engine", "'cone_ipm{cone=true}'"}) {
    const ProgramRun run = capture("bouncing-balls " + engine() + "--steps 50 --every 1 --loop " + loop + " --out " +
                                   (std::string(loop) == "engine" ? "own.scenes" : "loop.scenes"));
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  const ScenesFile own((folder_ / "own.scenes").string()), loop((folder_ / "loop.scenes").string());
  ASSERT_EQ(own.count(), loop.count());
  const Vector expected = own.read(own.count() - 1).problem.contact()->v;
  EXPECT_LT((loop.read(loop.count() - 1).problem.contact()->v - expected).norm(), 1e-6 * expected.norm());
}

TEST_F(ExternalEngine, AnEngineThatFailsLosesNoStepBeforeIt) {
  for (const auto& [fault, words] : {
           std::pair("die", "step 49: exited with code 1 without an answer; stderr: the balls are lost"),
           std::pair("pair", "step 49: contacts[0].bodies: expected two"),
           std::pair("motions", "step 49: motions: expected one for each body"),
           std::pair("turn", "step 49: motions[1]: its quaternion is not of length 1"),
           std::pair("time", "step 49: solve_s: is negative"), std::pair("list", "step 49: expected an object"),
           std::pair("number", "step 49: motions[0][0]: ")}) {
    const ProgramRun run = bouncing(fault);
    EXPECT_EQ(run.exit_code, 1) << fault << run.out;
    EXPECT_NE(run.err.find(words), std::string::npos) << fault << ": " << run.err;
    const ScenesFile file((folder_ / "balls.scenes").string());
    ASSERT_GE(file.count(), 1U);
    EXPECT_LT(file.step_number(file.count() - 1), 49);
  }
}

TEST_F(ExternalEngine, ContactsKeepTheirNamesWhicheverBodyIsToldFirst) {
  ASSERT_EQ(bouncing().exit_code, 0);
  fs::rename(folder_ / "balls.scenes", folder_ / "one_order.scenes");
  ASSERT_EQ(bouncing("order").exit_code, 0);
  const ScenesFile expected((folder_ / "one_order.scenes").string()), file((folder_ / "balls.scenes").string());
  ASSERT_EQ(file.count(), expected.count());
  for (std::size_t i = 0; i < file.count(); ++i) {
    const auto step = file.read(i), same = expected.read(i);
    EXPECT_EQ(step.contact_ids, same.contact_ids) << i;
    EXPECT_EQ(step.engine_impulses, same.engine_impulses) << i;
  }
}

TEST_F(ExternalEngine, ImpulsesThatDoNotExplainTheVelocitiesAreTold) {
  EXPECT_EQ(bouncing().err.find("do not explain"), std::string::npos);
  const ProgramRun run = bouncing("sign");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("external said: step "), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("the impulses do not explain"), std::string::npos) << run.err;
}

TEST_F(ExternalEngine, WhatIsNoEngineIsOneLine) {
  for (const auto& [arguments, words] :
       {std::pair("--engine 'external{command=./none}'", "./none"),
        std::pair("--engine external",
                  "--engine 'external': expected ode, bullet, mujoco, dart or external{command=...}"),
        std::pair("--engine jolt", "--engine 'jolt': expected ode, bullet, mujoco, dart or external{command=...}")}) {
    const ProgramRun run = capture(std::string("bouncing-balls ") + arguments);
    EXPECT_EQ(run.exit_code, 2) << run.out;
    EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
  const ProgramRun silent = bouncing("silent");
  EXPECT_EQ(silent.exit_code, 2);
  EXPECT_NE(silent.err.find("balls_engine.py"), std::string::npos) << silent.err;
  const ProgramRun joints = capture("hand " + engine());
  EXPECT_EQ(joints.exit_code, 2);
  EXPECT_NE(joints.err.find("scene 'hand' has joints"), std::string::npos) << joints.err;
}

}  // namespace
}  // namespace lcpbench::external_engine_test
