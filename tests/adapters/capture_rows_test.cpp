// Bounded rows of the joints of scenes, as each engine has them. A test of an engine that is not installed is skipped.
#include <algorithm>
#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/scenes_file.h"
#include "tests/adapters/capture_folder.h"
#include "tests/support/program_run.h"

namespace lcpbench::capture_rows_test {
namespace {

class CaptureRows : public Capture, public ::testing::WithParamInterface<const char*> {
 protected:
  void SetUp() override {
    if (!installed(GetParam())) GTEST_SKIP() << GetParam() << " is not installed";
  }
  /// DART's and MuJoCo's hinges take coordinates away, ODE's and Bullet's are rows.
  static bool is_reduced() { return std::string(GetParam()) == "dart" || std::string(GetParam()) == "mujoco"; }

  std::vector<double> velocity_of(const std::string& step) const {
    const ProgramRun run = run_program(folder_, "solve '" + step + "' --solver auto --format json");
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return nlohmann::json::parse(run.out).at(0).at("velocity").get<std::vector<double>>();
  }
};

Index count_of(const BoundedRows& rows, const std::string& kind) {
  return std::ranges::count_if(rows.names, [&](const std::string& name) { return name.starts_with(kind); });
}

Vector times(const Jacobian& J, const Vector& f) {
  return std::visit([&](const auto& matrix) { return Vector(matrix * f); }, J);
}

/// The part of the larger momentum that the engine's impulses and its velocity do not share.
double momentum_error(const SceneStep& step) {
  const ContactProblem& problem = *step.problem.contact();
  const Vector& f = step.engine_impulses;
  Vector impulse = times(problem.N, f.head(problem.nc())) + times(problem.D, f.segment(problem.nc(), cols(problem.D)));
  if (problem.has_rows()) impulse += times(problem.rows.R, f.tail(problem.rows.size()));
  const Vector momentum = dense_inertia(problem.inertia) * (step.engine_velocity - problem.v);
  return (impulse - momentum).norm() / std::max(impulse.norm(), momentum.norm());
}

/// How far the engine's answer is from the conditions of the bounded rows [m/s, rad/s].
double worst_residual(const SceneStep& step) {
  const ContactProblem& problem = *step.problem.contact();
  const BoundedRows& rows = problem.rows;
  if (!problem.has_rows()) return 0;
  const Matrix R = to_dense(rows.R), inverse = inverse_inertia(problem.inertia);
  const Vector f = step.engine_impulses.tail(rows.size());
  double worst = 0;
  for (Index i = 0; i < rows.size(); ++i) {
    const double scale = R.col(i).dot(inverse * R.col(i)) + rows.yields(i);
    const double w = R.col(i).dot(step.engine_velocity) + rows.offset(i) + rows.yields(i) * f(i);
    const double above = scale * (f(i) - rows.bounds.lower(i)), below = scale * (f(i) - rows.bounds.upper(i));
    worst = std::max(worst, std::abs(std::max(below, std::min(above, w))));
  }
  return worst;
}

/// Engines that solve by sweeps, and have motors in the solve. MuJoCo has neither.
using CaptureRowsOfSweeps = CaptureRows;

/// What `--soft` writes are the engine's own rows: with many sweeps it solves them. A correction of positions with the
/// wrong sign leaves a residual of 1e-4 or more.
TEST_P(CaptureRowsOfSweeps, ManySweepsSolveTheEnginesOwnRows) {
  for (const std::string scene : {"door", "four-bar", "motor", "quadruped-trotting", "jaws"}) {
    const bool grips = scene == "jaws";  // what the jaws hold takes more sweeps
    const std::string steps = grips ? " --steps 61" : "";
    const ScenesFile file = captured(scene, GetParam(), "--soft exact --every 20" + steps);
    ASSERT_GE(file.count(), grips ? 4U : 18U) << scene;
    for (std::size_t i = 0; i < file.count(); ++i) {
      const SceneStep step = file.read(i);
      EXPECT_LT(momentum_error(step), 1e-9) << scene << " step " << step.step;
      EXPECT_LT(worst_residual(step), 5e-5) << scene << " step " << step.step;
    }
  }
}

/// The impulses that an engine tells are those of the rows also where it solves others.
TEST_P(CaptureRows, ImpulsesExplainTheVelocityThatTheEngineFound) {
  // Bullet applies a contact's impulse to each body at its own end of the gap, and a problem's contact has one point.
  const double bound = std::string(GetParam()) == "bullet" ? 1e-2 : 1e-9;
  for (const char* scene : {"door", "four-bar", "hand"}) {
    const ScenesFile file = captured(scene, GetParam(), "--every 40");
    for (std::size_t i = 0; i < file.count(); ++i) EXPECT_LT(momentum_error(file.read(i)), bound) << scene << " " << i;
  }
}

/// At first the door turns at h (F l - tau) / I about its hinge, with the push F at l = 0.45 m and dry friction tau.
TEST_P(CaptureRows, ADoorOnADryHinge) {
  const ScenesFile file = captured("door", GetParam(), "--every 1 --steps 62");
  const SceneStep first = file.read(0);
  const BoundedRows& rows = first.problem.contact()->rows;
  EXPECT_EQ(rows.size(), is_reduced() ? 1 : 6);
  EXPECT_EQ(count_of(rows, "hinge equality j2"), is_reduced() ? 0 : 5);
  EXPECT_EQ(rows.names.back(), "hinge friction j2");
  const double h = file.header().step_length.value();
  EXPECT_EQ(rows.bounds.upper(rows.size() - 1), h * 2);
  EXPECT_EQ(rows.bounds.lower(rows.size() - 1), -h * 2);
  EXPECT_EQ(rows.is_angle.back(), 1);
  const double I = 10 * ((0.8 * 0.8 + 0.04 * 0.04) / 12 + 0.45 * 0.45);
  const std::vector<double> velocity = velocity_of("door.scenes#0");
  EXPECT_NEAR(velocity[is_reduced() ? 0 : 5], h * (30 * 0.45 - 2) / I, 1e-14);
  if (!is_reduced()) return;
  const SceneStep coasting = file.read(61);  // without the push
  if (std::string(GetParam()) == "mujoco") return;  // softer
  EXPECT_NEAR(coasting.engine_velocity(0), coasting.problem.contact()->v(0) - h * 2 / I, 1e-14);
}

/// The loop's row out of the plane moves nothing in the coordinates of a chain, and is one of the rows of bodies.
TEST_P(CaptureRows, ALinkageMovesAlikeInAllEngines) {
  const std::string engine = GetParam();
  const ScenesFile file = captured("four-bar", engine, "--every 1 --steps 2");
  const SceneStep step = file.read(0);
  const BoundedRows& rows = step.problem.contact()->rows;
  EXPECT_EQ(count_of(rows, "connect equality 0"), is_reduced() ? 2 : 3);
  EXPECT_EQ(count_of(rows, "hinge equality"), is_reduced() ? 0 : 15);
  EXPECT_EQ(count_of(rows, "hinge friction j2"), 1);
  EXPECT_EQ(rows.size(), is_reduced() ? 3 : 19);
  ASSERT_EQ(step.notes.size(), is_reduced() ? 1U : 0U);
  for (const std::string& note : step.notes) EXPECT_TRUE(note.ends_with("left out: 1")) << note;
  // Angular velocities of crank, coupler and rocker about the axes of their hinges: those of joints add up.
  const std::vector<double> v = velocity_of("four-bar.scenes#0");
  const std::vector<double> rates =
      is_reduced() ? std::vector{v[0], v[0] + v[1], v[0] + v[1] + v[2]} : std::vector{v[4], v[10], v[16]};
  // It has one freedom, and at first both ends of the coupler move alike: at h (F l - tau) / I about the crank's hinge,
  // with the push F, the crank's length l and its dry friction tau.
  const auto inertia = [](double half_width, double half_length, double arm) {
    return (half_width * half_width + half_length * half_length) / 3 + arm * arm;
  };
  const double ratio = 0.3 / 0.5;
  const double I = inertia(0.02, 0.13, 0.15) + 0.3 * 0.3 + ratio * ratio * inertia(0.02, 0.23, 0.25);
  EXPECT_NEAR(rates[0], 0.0025 * (4 * 0.3 - 0.2) / I, 1e-12);
  EXPECT_NEAR(rates[1], 0, 1e-12);
  EXPECT_NEAR(rates[2], ratio * rates[0], 1e-12);
}

/// At first the motor gives all it has, then it keeps its speed, and at the limit it pushes against it.
TEST_P(CaptureRowsOfSweeps, AMotorWithLittleToSpare) {
  const ScenesFile file = captured("motor", GetParam(), "--every 20 --loop auto");
  const double h = file.header().step_length.value();
  std::vector<std::string> states;
  const ProgramRun run = run_program(folder_, "solve motor.scenes --solver auto --format json");
  for (const auto& answer : nlohmann::json::parse(run.out)) {
    EXPECT_EQ(answer.at("verdict"), "solved");
    bool at_limit = false;
    for (const auto& row : answer.at("rows")) {
      if (row.at("name") == "hinge limit j2") at_limit = true;
      if (row.at("name") != "hinge motor j2") continue;
      EXPECT_EQ(row.at("upper"), h * 4);
      EXPECT_LE(row.at("velocity").get<double>(), 1e-6);
      states.push_back(at_limit ? "at the limit" : row.at("state").get<std::string>());
    }
  }
  EXPECT_EQ(states.size(), file.count());
  states.erase(std::ranges::unique(states).begin(), states.end());
  EXPECT_EQ(states, (std::vector<std::string>{"at its upper bound", "between", "at the limit"}));
}

/// At first no motor reaches its speed: the carriage rises at h (F / m - g), the jaws close at h F / m.
TEST_P(CaptureRowsOfSweeps, JawsCloseByMotorsOfLimitedForce) {
  const ScenesFile file = captured("jaws", GetParam(), "--every 1 --steps 1");
  const SceneStep step = file.read(0);
  const BoundedRows& rows = step.problem.contact()->rows;
  EXPECT_EQ(count_of(rows, "slide motor"), 3);
  const int equalities = std::string(GetParam()) == "bullet" ? 12 : 15;  // none about an axis before there is a turn
  EXPECT_EQ(count_of(rows, "slide equality"), is_reduced() ? 0 : equalities);
  EXPECT_EQ(rows.is_angle.back(), 0);
  const std::vector<double> v = velocity_of("jaws.scenes#0");
  const double h = file.header().step_length.value(), closing = h * 25 / 0.5;
  EXPECT_NEAR(is_reduced() ? v[0] : v[2], h * (60 / 3.0 - 9.81), 1e-12);
  EXPECT_NEAR(is_reduced() ? v[1] : v[6], closing, 1e-12);
  EXPECT_NEAR(is_reduced() ? v[2] : -v[12], closing, 1e-12);
}

std::string name_of(const ::testing::TestParamInfo<const char*>& engine) { return engine.param; }

INSTANTIATE_TEST_SUITE_P(All, CaptureRows, ::testing::Values("ode", "bullet", "dart", "mujoco"), name_of);
INSTANTIATE_TEST_SUITE_P(All, CaptureRowsOfSweeps, ::testing::Values("ode", "bullet", "dart"), name_of);

TEST_F(Capture, MuJoCoRefusesAMotorInTheSolve) {
  if (!installed("mujoco")) GTEST_SKIP() << "mujoco is not installed";
  const ProgramRun run = capture("motor --engine mujoco");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("scene 'motor' has a motor in the engine's solve"), std::string::npos) << run.err;
}

/// What an engine leaves out of its step at a limit is in the problem, and is said.
TEST_F(Capture, WhatEnginesLeaveOutAtALimitIsSaid) {
  for (const auto& [engine, words] : {std::pair("dart", "motors at a limit, which DART leaves out: "),
                                      std::pair("bullet", "motors and dry friction at a limit or before it, which "
                                                          "Bullet leaves out or slows: ")}) {
    if (!installed(engine)) continue;
    const ProgramRun run = capture(std::string("motor --out m.scenes --every 1 --engine ") + engine);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
    const ScenesFile file((folder_ / "m.scenes").string());
    bool both = false;
    for (std::size_t i = 0; i < file.count(); ++i) {
      const SceneStep step = file.read(i);
      const BoundedRows& rows = step.problem.contact()->rows;
      EXPECT_EQ(count_of(rows, "hinge motor j2"), 1) << engine << " step " << i;
      both = both || count_of(rows, "hinge limit j2") == 1;
    }
    EXPECT_TRUE(both) << engine;
  }
}

}  // namespace
}  // namespace lcpbench::capture_rows_test
