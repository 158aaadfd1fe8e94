// Engines that capture scenes, run as users run them. A test of an engine that is not installed is skipped.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "core/entries.h"
#include "core/io/problem_io.h"
#include "core/io/scenes_file.h"
#include "tests/adapters/capture_folder.h"
#include "tests/support/program_run.h"

namespace lcpbench::capture_command_test {
namespace {

/// Whether Debian's package is installed, as dpkg's list of its files tells.
bool has_package(const std::string& package) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator("/var/lib/dpkg/info", error)) {
    const std::string name = entry.path().filename().string();
    if (name == package + ".list" || (name.starts_with(package + ":") && name.ends_with(".list"))) return true;
  }
  return false;
}

class CaptureEngine : public Capture, public ::testing::WithParamInterface<const char*> {
 protected:
  void SetUp() override {
    if (!installed(GetParam())) GTEST_SKIP() << GetParam() << " is not installed";
  }
};

/// How far G (v+ - v) and N f_N + D f_D are apart, relative to the larger: the engine's impulses must explain the
/// velocity that the engine found, which fails for any wrong sign, arm, inertia or force.
double momentum_error(const SceneStep& step) {
  const ContactProblem& problem = *step.problem.contact();
  const auto times = [](const Jacobian& J, const Vector& f) {
    return std::visit([&](const auto& matrix) { return Vector(matrix * f); }, J);
  };
  const Vector& f = step.engine_impulses;
  Vector impulse = times(problem.N, f.head(problem.nc())) +
                   times(problem.D, f.segment(problem.nc(), cols(problem.D)));
  if (problem.has_rows()) impulse += times(problem.rows.R, f.tail(problem.rows.size()));
  const Vector momentum = dense_inertia(problem.inertia) * (step.engine_velocity - problem.v);
  constexpr double kNothing = 1e-6;  // N s: a loop that falls freely has rounding
  return (impulse - momentum).norm() / std::max({impulse.norm(), momentum.norm(), kNothing});
}

void expect_sane(const SceneStep& step) {
  const RigidScene& scene = *step.problem.scene();
  ASSERT_EQ(step.gap.size(), scene.contacts.size());
  ASSERT_EQ(step.contact_ids.size(), scene.contacts.size());
  for (const RigidBody& body : scene.bodies) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(body.inertia, Eigen::EigenvaluesOnly);
    EXPECT_GT(eigen.eigenvalues()(0), 0);
  }
  for (const RigidContact& contact : scene.contacts) {
    EXPECT_NEAR(contact.normal.norm(), 1, 1e-12);
    EXPECT_NEAR(contact.tangent.norm(), 1, 1e-12);
    EXPECT_NEAR(contact.normal.dot(contact.tangent), 0, 1e-12);
    EXPECT_EQ(contact.edges, 4);
  }
}

// A URDF as it is has no ground, and its root link is fixed; with the two lines that the command prints it touches.
TEST_F(Capture, AUrdfThatTouchesNothingIsToldTheLinesItNeeds) {
  if (!installed("mujoco")) GTEST_SKIP() << "mujoco is not installed";
  const std::string link =
      R"(<link name="base"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0")"
      R"( iyz="0"/></inertial><collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link></robot>)";
  std::ofstream(folder_ / "bare.urdf") << "<robot name=\"r\">\n" << link;
  const ProgramRun bare = capture("r --model bare.urdf --steps 400");
  EXPECT_EQ(bare.exit_code, 1);
  EXPECT_NE(bare.err.find("bare.urdf is a URDF"), std::string::npos) << bare.err;
  const std::size_t begin = bare.err.find("  <link name=\"world\">");
  ASSERT_NE(begin, std::string::npos) << bare.err;
  std::string lines = bare.err.substr(begin);
  lines.replace(lines.find("BASE"), 4, "base");
  std::ofstream(folder_ / "whole.urdf") << "<robot name=\"r\">\n" << lines << link;
  const ProgramRun whole = capture("r --model whole.urdf --steps 400");
  EXPECT_EQ(whole.exit_code, 0) << whole.err;
}

/// A search that stops to find a library would otherwise only skip this engine's tests.
TEST_F(Capture, EveryEngineWhosePackageIsInstalledIsBuilt) {
  for (const char* engine : {"ode", "bullet", "mujoco", "dart"}) {
#ifdef __SANITIZE_ADDRESS__
    if (std::string(engine) == "dart") continue;  // left out of builds with sanitizers
#endif
    EXPECT_TRUE(installed(engine) || !has_package("lib" + std::string(engine) + "-dev")) << engine;
  }
}

TEST_P(CaptureEngine, RepeatsItsBytes) {
  captured("box-pile", GetParam(), "--steps 200 --every 40");
  const std::string first = read_file(folder_ / "box-pile.scenes");
  captured("box-pile", GetParam(), "--steps 200 --every 40");
  EXPECT_FALSE(first.empty());
  EXPECT_EQ(first, read_file(folder_ / "box-pile.scenes"));
}

TEST_P(CaptureEngine, ARestingStackFallsByTheGravityOfOneStep) {
  const ScenesFile file = captured("stack", GetParam(), "--steps 100 --every 30");
  ASSERT_GE(file.count(), 3U);
  const double h = file.header().step_length.value();
  const SceneStep step = file.read(file.count() - 1);
  expect_sane(step);
  double sum = 0;
  int count = 0;
  const RigidScene& scene = *step.problem.scene();
  for (const RigidContact& contact : scene.contacts) {
    if (contact.body_b != RigidContact::kWorld) continue;
    const RigidBody& body = scene.bodies[static_cast<std::size_t>(contact.body_a)];
    sum += contact.normal.dot(body.linear_velocity + body.angular_velocity.cross(contact.point - body.position));
    ++count;
  }
  ASSERT_GE(count, 4);
  EXPECT_NEAR(sum / count, -9.81 * h, 0.3 * 9.81 * h);
}

TEST_P(CaptureEngine, ImpulsesExplainTheVelocityThatTheEngineFound) {
  // Bullet applies friction to both bodies, each at its own end of the gap, and a problem's contact has one point.
  const double bound = std::string(GetParam()) == "bullet" ? 1e-2 : 1e-9;
  for (const char* scene : {"card-house", "box-pile", "spinning-plate", "uneven-table"}) {
    const ScenesFile file = captured(scene, GetParam(), "--steps 150 --every 25");
    ASSERT_GE(file.count(), 3U) << scene;
    for (std::size_t i = 0; i < file.count(); ++i) {
      const SceneStep step = file.read(i);
      ASSERT_EQ(step.engine_velocity.size(), step.problem.contact()->ngc());
      EXPECT_LT(momentum_error(step), bound) << scene << " step " << step.step;
    }
  }
}

TEST_P(CaptureEngine, ContactsKeepTheirNames) {
  const ScenesFile file = captured("gripper", GetParam(), "--steps 100 --every 1");
  const auto names = [&](std::size_t i) { return file.read(i).contact_ids; };
  const std::vector<std::string> before = names(file.count() - 2);
  const std::vector<std::string> after = names(file.count() - 1);
  const auto kept = std::count_if(after.begin(), after.end(), [&](const std::string& id) {
    return std::find(before.begin(), before.end(), id) != before.end();
  });
  EXPECT_GE(2 * kept, static_cast<std::ptrdiff_t>(after.size()));
}

/// Leaning cards have solutions of friction in which they slip, and one in which the house rests.
TEST_P(CaptureEngine, ACardHouseStandsWhereASolverRests) {
  const ScenesFile file = captured("card-house", GetParam(), "--loop auto --steps 300 --every 20");
  ASSERT_GE(file.step_number(file.count() - 1), 280);
  const std::vector<RigidBody> at_first = file.read(0).problem.scene()->bodies;
  for (std::size_t i = 1; i < file.count(); ++i) {
    const std::vector<RigidBody> bodies = file.read(i).problem.scene()->bodies;
    ASSERT_EQ(bodies.size(), at_first.size());
    for (std::size_t body = 0; body < bodies.size(); ++body) {
      EXPECT_LT((bodies[body].position - at_first[body].position).norm(), 0.005) << "step " << file.step_number(i);
    }
  }
}

/// A body without contacts of its own falls by gravity alone: its velocity before the impacts of a step is that after
/// those of the step before, plus h g. So the velocity that moves the scene on is the one that `auto` finds.
TEST_P(CaptureEngine, ASolverInTheLoopMovesTheSceneOn) {
  const ScenesFile file = captured("sphere-pile", GetParam(), "--loop auto --steps 80 --every 1");
  EXPECT_EQ(file.header().loop, "auto");
  ASSERT_GE(file.count(), 10U);
  const std::size_t last = file.count() - 2;
  ASSERT_EQ(file.step_number(last) + 1, file.step_number(last + 1));
  const SceneStep step = file.read(last);
  EXPECT_EQ(step.engine_impulses.size(), 0) << "the engine solved nothing";
  EXPECT_EQ(step.engine_velocity.size(), 0);
  const ProgramRun run =
      run_program(folder_, "solve 'sphere-pile.scenes#" + std::to_string(step.step) + "' --solver auto --format json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto velocity = nlohmann::json::parse(run.out).at(0).at("velocity").get<std::vector<double>>();
  // DART's coordinates turn with a body, so that its velocity changes a little while the body spins.
  const double bound = std::string(GetParam()) == "dart" ? 1e-3 : 1e-12;
  const SceneStep after = file.read(last + 1);
  const Vector& next = after.problem.contact()->v;
  ASSERT_EQ(next.size(), static_cast<Index>(velocity.size()));
  double fastest = 0;
  for (Index i = 0; i < next.size(); i += 6) {
    for (Index k = 0; k < 3; ++k) {
      const double gravity = k == 2 ? -9.81 * file.header().step_length.value() : 0;
      EXPECT_NEAR(next(i + k), velocity[static_cast<std::size_t>(i + k)] + gravity, bound);
      fastest = std::max(fastest, std::abs(next(i + k)));
    }
  }
  EXPECT_GT(fastest, 0.1);
  EXPECT_GT(step.problem.contact()->nc(), 0);
}

/// A contact that opens by a rounding error is not lost, which would let the load on it fall for a step. The engine's own
/// step gets what its detection finds by itself: where shapes touch or overlap. Bullet has a margin of its own.
TEST_P(CaptureEngine, ASolverInTheLoopKeepsTheContactsOfWhatRests) {
  if (std::string(GetParam()) == "bullet") GTEST_SKIP() << "gathers the contacts of two bodies over several steps";
  const bool mujoco = std::string(GetParam()) == "mujoco";  // finds a contact twice in some steps
  for (const auto& [scene, contacts] : {std::pair("cubes-10", 40), std::pair("arch", mujoco ? 71 : 72)}) {
    const ScenesFile file = captured(scene, GetParam(), "--loop auto --steps 60 --every 1");
    ASSERT_EQ(file.count(), 60U) << "no step is without contacts";
    for (std::size_t i = 0; i < file.count(); ++i) {
      const Index found = file.read(i).problem.contact()->nc();
      EXPECT_TRUE(mujoco ? found >= contacts : found == contacts) << found << " in " << scene << " step " << i;
    }
  }
  const ScenesFile own = captured("arch", GetParam(), "--steps 60 --every 10");
  for (std::size_t i = 0; i < own.count(); ++i) {
    for (const double gap : own.read(i).gap) EXPECT_LE(gap, 0);
  }
}

/// What `--soft` writes is the engine's own model: with many sweeps its answer becomes exact. A compliance, an error
/// reduction or a bounce that is wrong by a thousandth leaves a residual of 1e-4. (A box on DART has two compliances
/// along two tangents, where a contact of a problem has one; a sphere's are equal.)
TEST_P(CaptureEngine, ManySweepsSolveTheEnginesOwnModel) {
  const std::string engine = GetParam();
  if (engine == "mujoco") GTEST_SKIP() << "has its own test in Python";
  const std::string soft = engine == "dart" ? "{cfm=0.3,erp=0.3}" : "{cfm=0.0003,erp=0.3}";
  for (const std::string scene : {"stack", "bouncing-balls", "sphere-pile"}) {
    if (engine == "dart" && scene == "stack") continue;
    const std::string spec = scene + soft;
    const ProgramRun run =
        capture("'" + spec + "' --engine " + engine + " --soft exact --steps 121 --every 20 --out soft.scenes");
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const ScenesFile file((folder_ / "soft.scenes").string());
    ASSERT_GE(file.count(), 3U) << spec;
    for (std::size_t i = 0; i < file.count(); ++i) {
      const SceneStep step = file.read(i);
      if (step.engine_impulses.isZero(0)) continue;  // nothing against rounding
      EXPECT_LT(momentum_error(step), 1e-9) << spec;
    }
    const ProgramRun solved = run_program(folder_, "solve soft.scenes --solver engine --format json");
    for (const auto& answer : nlohmann::json::parse(solved.out)) {
      EXPECT_EQ(answer.at("verdict"), "solved") << spec;
      EXPECT_LT(answer.at("errors").at("velocity_residual_relative").get<double>(), 1e-10) << spec;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, CaptureEngine, ::testing::Values("ode", "bullet", "mujoco", "dart"),
                         [](const auto& parameter) { return std::string(parameter.param); });

TEST_F(Capture, MuJoCosRobotsMoveAsTheirBlocksSay) {
  if (!installed("mujoco")) GTEST_SKIP() << "mujoco is not installed";
  // Joints with limits, a closed chain, and a hand with an object.
  for (const char* scene : {"quadruped-trotting", "closed-chain", "hand"}) {
    const ScenesFile file = captured(scene, "mujoco", "--steps 200 --every 40");
    ASSERT_GE(file.count(), 2U) << scene;
    for (std::size_t i = 0; i < file.count(); ++i) EXPECT_LT(momentum_error(file.read(i)), 1e-9) << scene;
  }
  // Six links with a free base have 11 coordinates; of the loop's three rows the one out of its plane says nothing.
  const SceneStep chain = captured("closed-chain", "mujoco", "--steps 200").read(0);
  EXPECT_EQ(chain.problem.contact()->ngc(), 11);
  EXPECT_EQ(std::ranges::count_if(chain.problem.contact()->rows.names,
                                  [](const std::string& name) { return name.starts_with("connect equality"); }),
            2);
}

TEST_F(Capture, TakesAModelOfTheUsers) {
  if (!installed("mujoco")) GTEST_SKIP() << "mujoco is not installed";
  std::ofstream(folder_ / "ball.xml")
      << R"(<mujoco><option gravity="0 0 -1.5"/><worldbody><geom type="plane" size="1 1 1"/>
    <body pos="0 0 0.1"><freejoint/><geom type="sphere" size="0.1"/></body></worldbody>
    <keyframe><key qpos="0.5 0 0.1 1 0 0 0"/></keyframe></mujoco>)";
  const ScenesFile file = captured("ball", "mujoco", "--model ball.xml --steps 50 --every 10");
  ASSERT_GE(file.count(), 1U);
  EXPECT_EQ(file.read(0).problem.contact()->ngc(), 6);
  EXPECT_EQ(file.read(0).poses.at(1).at(0), 0.5);
  EXPECT_EQ(file.header().gravity, (std::vector<double>{0, 0, -1.5}));
  const ProgramRun wrong = capture("ball --model out");  // the file of the standard output: not a model
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.err.find("model 'out'"), std::string::npos) << wrong.err;
}

/// A shelf that the friction of its rail holds, in the capture and in a replay: it is no fault of MuJoCo's that it stands.
TEST_F(Capture, WhatAModelHasBesidesContactsActsAndIsSaid) {
  if (!installed("mujoco")) GTEST_SKIP() << "mujoco is not installed";
  std::ofstream(folder_ / "shelf.xml")
      << R"(<mujoco><option timestep="0.005" integrator="RK4"/><worldbody><geom name="floor" type="plane" size="5 5 .1"/>
    <body name="shelf" pos="0 0 1"><joint name="rail" type="slide" axis="0 0 1" frictionloss="50" range="-2 -.0001" limited="true"/>
      <geom type="box" size=".3 .3 .02" mass="1"/></body>
    <body name="jar" pos="0 0 1.0695"><freejoint/><geom name="jar" type="box" size=".05 .05 .05" mass=".2"/></body>
    <body pos="2 0 .0995"><freejoint/><geom name="sled" type="box" size=".1 .1 .1" mass="1"/></body></worldbody>
    <contact><pair geom1="sled" geom2="floor" friction="0.05 0.4 0 0 0"/></contact>
    <keyframe><key qpos="0 0 0 1.0695 1 0 0 0 2 0 .0995 1 0 0 0" qvel="0 0 0 0 0 0 0 .6 .7 0 0 0 0"/></keyframe></mujoco>)";
  const ProgramRun run = capture("m --engine mujoco --model shelf.xml --steps 40 --every 1 --out m.scenes");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* words : {"steps of the integrator RK4, which Euler's rule took: 40",
                            "contacts with two coefficients of sliding friction: the second tangent is scaled: "}) {
    EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
  }
  const ScenesFile file((folder_ / "m.scenes").string());
  for (std::size_t i = 0; i < file.count(); ++i) {
    const SceneStep step = file.read(i);
    EXPECT_LT(momentum_error(step), 1e-9);
    EXPECT_GE(step.notes.size(), 1U);
    const BoundedRows& rows = step.problem.contact()->rows;
    ASSERT_EQ(rows.names.front(), "slide friction rail");
    EXPECT_EQ(rows.bounds.upper(0), 0.005 * 50);
  }
  EXPECT_EQ(file.read(0).problem.contact()->rows.names.back(), "slide limit rail");
  const std::vector<std::string> ids = file.read(0).contact_ids;
  for (const char* each : {"jar on shelf", "jar on shelf #2", "sled on floor"}) {
    EXPECT_EQ(std::ranges::count(ids, each), 1) << each;
  }
  const ProgramRun replay = run_program(folder_, "replay m --model shelf.xml --stands shelf --solver auto --engine-solver "
                                                 "--steps 200 --out made --format json");
  ASSERT_EQ(replay.exit_code, 0) << replay.err;
  const nlohmann::json replays = nlohmann::json::parse(replay.out)[0]["replays"];
  for (const std::size_t i : {0U, 1U}) {
    EXPECT_EQ(replays[i]["survived"], 200) << replay.out;
    EXPECT_LT(replays[i]["drift_m"].get<double>(), 0.02) << replay.out;
  }
}

/// The step that the solver of the loop fails on is kept: it is the one to look at.
TEST_F(Capture, ASolverThatFailsEndsTheCapture) {
  if (!installed("ode")) GTEST_SKIP() << "ode is not installed";
  const ProgramRun run = capture("card-house --engine ode --loop 'psor{max_iterations=3}' --out failed.scenes");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("step 0: psor{max_iterations=3} did not solve it: iteration_limit"), std::string::npos)
      << run.err;
  EXPECT_EQ(ScenesFile((folder_ / "failed.scenes").string()).count(), 1U);
}

TEST_F(Capture, NamesWhatIsWrong) {
  const auto refused = [&](const std::string& arguments, const std::string& words) {
    const ProgramRun run = capture(arguments);
    EXPECT_EQ(run.exit_code, 2) << arguments;
    EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  };
  refused("stak", "did you mean 'stack'?");
  refused("stack --engine havok", "--engine");
  refused("stack --every 0", "--every");
  refused("stack --loop bullet_si", "--loop 'bullet_si'");
  refused("stack --loop outo", "did you mean 'auto'?");
  refused("robot --model missing.xml", "--model 'missing.xml': no such file");
  if (installed("ode")) {
    refused("humanoid-lying --engine ode", "scene 'humanoid-lying' is a model of MuJoCo's and runs there only");
    refused("'stack{elliptic=true}' --engine ode", "scene 'stack{elliptic=true}': elliptic cones are MuJoCo's alone");
    refused("'stack{sweeps=20}' --engine ode --soft exact", "--soft exact sets the sweeps itself, to 1,000");
    refused("stack --engine ode --soft pgs", "--soft pgs: a solver of MuJoCo's");
    refused("stack --out nowhere/stack.scenes", "nowhere/stack.scenes");
  }
  EXPECT_FALSE(fs::exists(folder_ / "stack-ode.scenes"));
}

}  // namespace
}  // namespace lcpbench::capture_command_test
