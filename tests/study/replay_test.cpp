// Scenes stepped on with the answers of solvers: the command as users run it.
#include "study/replay/replay.h"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/scenes_file.h"
#include "study/replay/claims.h"
#include "tests/support/page_document.h"
#include "tests/support/program_test.h"

namespace lcpbench::replay_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class ReplayCommand : public ProgramTest {
 protected:
  static bool installed(const std::string& engine) {
    return fs::exists(fs::path(LCPBENCH_PROGRAM).parent_path() / ("lcpbench-capture-" + engine));
  }
  /// The scenes that a replay tells, in FOLDER/made.
  json replay(const std::string& arguments) { return run_json("replay " + arguments + " --out made"); }
  std::string result(const std::string& name) { return read("made/" + name); }
};

/// A summary without its last column, the processor time.
std::string without_times(const std::string& summary) {
  std::istringstream lines(summary);
  std::string text;
  for (std::string line; std::getline(lines, line);) text += line.substr(0, line.rfind(',')) + "\n";
  return text;
}

/// The document of a page without the processor time of its replays.
json page_without_times(const std::string& page) {
  json document = document_of(page);
  for (json& replay : document["replays"]) {
    for (json& row : replay["replays"]) row.erase("cpu_s_per_s");
  }
  return document;
}

/// Of a scene's replays that of a stepper. @returns null where there is none
json replay_of(const json& scene, const std::string& solver) {
  for (const json& replay : scene["replays"]) {
    if (replay["solver"] == solver) return replay;
  }
  return {};
}

class ReplayEngine : public ReplayCommand, public ::testing::WithParamInterface<std::string> {};
INSTANTIATE_TEST_SUITE_P(All, ReplayEngine, ::testing::Values("ode", "bullet", "mujoco", "dart"),
                         [](const auto& engine) { return engine.param; });

// Without the projection the light boxes stay as deep in each other as the first steps press them.
TEST_P(ReplayEngine, PositionsAreProjectedAndAGoodSolverHoldsAHeavyLoad) {
  if (!installed(GetParam())) GTEST_SKIP() << GetParam() << " is not installed";
  const json scene = replay("mass-ratio-1e4 --engine " + GetParam() + " --solver auto --engine-solver --steps 60")[0];
  const json& auto_replay = scene["replays"][0];
  EXPECT_EQ(json({auto_replay["solver"], auto_replay["impulses"]}), json({"auto", "any"}));
  EXPECT_EQ(auto_replay["survived"], 60) << scene.dump();
  EXPECT_EQ(auto_replay["claimed_solved"], auto_replay["steps_with_contacts"]);
  EXPECT_LT(auto_replay["drift_m"].get<double>(), 0.01) << scene.dump();
  EXPECT_EQ(scene["replays"][1]["solver"], "engine");
  for (const fs::directory_entry& file : fs::directory_iterator(folder_ / "made" / "steps")) {
    if (file.path().extension() != ".csv" || file.path().string().find("auto") == std::string::npos) continue;
    const Replay replay = read_track(file.path(), "auto");
    EXPECT_LT(replay.steps.back().deepest_m, 1.2e-4) << GetParam();
  }
}

// Every engine hands its contacts, gaps and forces to every stepper, and moves on as the stepper says.
TEST_P(ReplayEngine, EveryStepperKeepsThreeCubes) {
  if (!installed(GetParam())) GTEST_SKIP() << GetParam() << " is not installed";
  const json scene = replay("cubes-3 --engine " + GetParam() +
                            " --solver auto --stepper convex --stepper pgs --stepper sequential_impulses --stepper "
                            "soft_step --stepper xpbd --stepper admm --stepper apgd --engine-solver --steps 100")[0];
  ASSERT_EQ(scene["replays"].size(), 10U);
  for (const json& replay : scene["replays"]) {
    if (replay["solver"] == "nothing") {
      EXPECT_LT(replay["survived"], 100) << replay.dump();
      continue;
    }
    EXPECT_EQ(replay["survived"], 100) << replay.dump();
    EXPECT_LT(replay["drift_m"].get<double>(), 0.02) << replay.dump();
    if (replay["solver"] == "engine" && GetParam() == "dart") continue;  // does not tell its time
    EXPECT_GT(replay["cpu_s_per_s"].get<double>(), 0) << replay.dump();
  }
  EXPECT_EQ(replay_of(scene, "auto")["stepper"], "exact");
}

// Sweeps that start from the last impulses keep what the same sweeps lose from zero.
TEST_F(ReplayCommand, AWarmStartKeepsTenCubes) {
  if (!installed("ode")) GTEST_SKIP() << "ode is not installed";
  const json scene =
      replay("cubes-10 --stepper 'sequential_impulses{warm=false}' --stepper sequential_impulses --steps 400")[0];
  EXPECT_LT(replay_of(scene, "sequential_impulses{warm=false}")["survived"], 400) << scene.dump();
  EXPECT_EQ(replay_of(scene, "sequential_impulses")["survived"], 400) << scene.dump();
}

TEST_F(ReplayCommand, AClaimIsTestedByItsPlan) {
  if (!installed("ode")) GTEST_SKIP() << "ode is not installed";
  write("plan.json", R"({"format": "lcpbench-claims", "version": 1, "claims": [
      {"id": "kept", "claim": "They stay.", "source": "a test", "measure": "drift_m", "limit": 0.02,
       "steppers": ["soft_step"], "scenes": ["cubes-3"]},
      {"id": "nearer", "claim": "The cone is near.", "source": "a test", "measure": "error_m",
       "steppers": ["exact{solver=cone_ipm{cone=true}}", "exact{solver=psor{max_iterations=1}}"], "scenes": ["cubes-3"]}]})");
  EXPECT_TRUE(contains(done("replay --plan plan.json --out made"), "kept: holds\nnearer: holds\n"));
  const std::string page = result("claims.md");
  EXPECT_NE(page.find("    lcpbench replay --plan plan.json --out FOLDER\n"), std::string::npos) << page;
  EXPECT_NE(page.find("| [They stay.](#kept) | holds |"), std::string::npos) << page;
  EXPECT_NE(page.find("| [The cone is near.](#nearer) | holds |"), std::string::npos) << page;
  EXPECT_TRUE(std::regex_search(page, std::regex(R"(\n\| cubes-3 \| [^|]+ \| lost \| yes \|\n)"))) << page;
  EXPECT_TRUE(std::regex_search(page, std::regex(R"(\n\| cubes-3 \| [^|]+ \| [^|]+ \| [0-9.]+ m \| yes \|\n)")))
      << page;
  for (const char* wrong :
       {"--plan plan.json --claim nosuch", "--plan nosuch.json", "stack --plan plan.json",
        "--plan plan.json --stepper pgs", "--plan plan.json --steps 5", "stack --claim kept --stepper pgs"}) {
    expect_mistake(std::string("replay --out made ") + wrong);
  }
  write("no.json", R"({"format": "lcpbench-claims", "version": 1, "claims": [{"id": "x",
      "claim": "y", "source": "z", "measure": "drift_m", "limit": 1, "steppers": ["pgs"], "scenes": ["hand"]}]})");
  EXPECT_TRUE(contains(run("replay --plan no.json --out no").err, "pgs knows free bodies only"));
}

TEST_F(ReplayCommand, ARobotOfTheUsersIsReplayed) {
  if (!installed("mujoco")) GTEST_SKIP() << "mujoco is not installed";
  std::ofstream(folder_ / "robot.xml") << "<mujoco><worldbody><geom type='plane' size='5 5 1'/><body pos='0 0 .3'>"
                                          "<freejoint/><geom type='box' size='.2 .1 .1'/><body pos='.25 0 0'>"
                                          "<joint axis='0 1 0'/><geom type='capsule' fromto='0 0 0 .3 0 0' size='.05'/>"
                                          "</body></body></worldbody></mujoco>";
  const json scene = replay(
      "my-robot --model robot.xml --stepper exact --stepper convex --stepper pgs "
      "--engine-solver --steps 150")[0];
  for (const std::string solver : {"exact", "convex", "engine"}) {  // as they were spelled
    EXPECT_GT(replay_of(scene, solver)["steps_with_contacts"], 20) << scene.dump();
    EXPECT_EQ(replay_of(scene, solver)["survived"], 150) << scene.dump();
  }
  EXPECT_TRUE(replay_of(scene, "pgs")["survived"].is_null()) << scene.dump();
  EXPECT_EQ(replay_of(scene, "pgs")["end"], "refused: it knows free bodies only, and the scene has joints");
  EXPECT_GT(replay_of(scene, "exact")["drift_m"].get<double>(), 0.1) << "it falls, and nobody said that it stands";
  EXPECT_EQ(run("replay my-robot --model nosuch.xml --stepper exact --out made").exit_code, 2);
}

// Bodies of a model without joints are free bodies: a light box under a heavy one, each off its body's origin, turned,
// and with a second body welded to it, on a ground that is no body.
TEST_F(ReplayCommand, FreeBodiesOfAModelAreFreeForEveryStepper) {
  if (!installed("mujoco")) GTEST_SKIP() << "mujoco is not installed";
  const auto box = [](const std::string& name, const char* height, const char* mass) {
    return "<body name='" + name + "' pos='0 0 " + height +
           "' euler='0 0 30'><freejoint/>"
           "<geom name='" +
           name + "-box' type='box' size='.5 .5 .5' pos='.1 .1 0' mass='" + mass +
           "'/>"
           "<body pos='.2 .2 .1'><geom type='sphere' size='.1' contype='0' conaffinity='0' mass='" +
           mass + "'/><site name='" + name + "-top' pos='0 0 .5'/></body></body>";
  };
  std::ofstream(folder_ / "heavy.xml")
      << "<mujoco><option timestep='.005'/><worldbody><geom type='plane' size='5 5 1'/>" << box("light", ".5", ".5")
      << box("heavy", "1.5", "50") << "</worldbody></mujoco>";
  const std::string steppers =
      "--solver auto --stepper pgs --stepper sequential_impulses --stepper soft_step --stepper "
      "xpbd --stepper admm --stepper apgd --engine-solver --steps 100 --format json ";
  const ProgramRun output = run("replay heavy --model heavy.xml --out made " + steppers);
  ASSERT_EQ(output.exit_code, 0) << output.err;
  const json scene = json::parse(output.out)[0];
  ASSERT_EQ(scene["replays"].size(), 9U);
  for (const json& replay : scene["replays"]) {
    EXPECT_TRUE(replay["energy_rise_j"].is_number()) << replay.dump();
    if (replay["solver"] == "nothing") continue;
    EXPECT_EQ(replay["survived"], 100) << replay.dump();
    EXPECT_GT(replay["steps_with_contacts"], 90) << replay.dump();  // some throw the boxes up a little
  }
  EXPECT_LT(replay_of(scene, "auto")["drift_m"].get<double>(), 1e-3) << scene.dump();
  EXPECT_GT(replay_of(scene, "nothing")["drift_m"].get<double>(), 1) << "half a second of free fall";
  const json named = json::parse(run("replay heavy --model heavy.xml --out named --stands heavy-top --grip heavy "
                                     "light-box --solver auto --steps 100 --format json")
                                     .out)[0];
  EXPECT_LT(replay_of(named, "nothing")["survived"], 100) << named.dump();
  EXPECT_LT(replay_of(named, "auto")["slip_m"].get<double>(), 1e-3) << named.dump();
  EXPECT_NE(run("replay heavy --model heavy.xml --stands nosuch --solver auto --out named").err.find("nosuch"),
            std::string::npos);
  EXPECT_EQ(run("replay stack --stands heavy --solver auto --out named").exit_code, 2);
}

// In half a period the ball comes to the mirror image of its start, whoever takes the steps.
TEST_F(ReplayCommand, APendulumSwingsAsItsClosedFormSays) {
  if (!installed("mujoco")) GTEST_SKIP() << "mujoco is not installed";
  constexpr double kAngle = 0.3;
  constexpr double kRadius = 0.05;
  const double inertia = 1 + 0.4 * kRadius * kRadius;  // of a ball of 1 kg on a rod of 1 m
  const double half_period = std::acos(-1) * std::sqrt(inertia / 9.81) * (1 + kAngle * kAngle / 16);
  std::ofstream(folder_ / "pendulum.xml")
      << "<mujoco><option timestep='" << half_period / 100
      << "'/><worldbody><body pos='0 0 2'><joint type='hinge' axis='0 1 0'/>"
      << "<geom type='sphere' size='" << kRadius << "' mass='1' pos='" << std::sin(kAngle) << " 0 " << -std::cos(kAngle)
      << "'/></body></worldbody></mujoco>";
  replay("pendulum --model pendulum.xml --stepper exact --stepper convex --engine-solver --steps 101");
  const json list = json::parse(result("replays.json"));
  for (const json& replay : list["scenes"][0]["replays"]) {
    const ScenesFile film(folder_ / "made" / "steps" / replay["file"].get<std::string>());
    const SceneStep last = film.read(film.count() - 1);
    EXPECT_EQ(last.step, 100);
    EXPECT_NEAR(last.poses[0][0], -std::sin(kAngle), 0.002) << replay.dump();
    EXPECT_NEAR(last.poses[0][2], 2 - std::cos(kAngle), 0.002) << replay.dump();
  }
  EXPECT_EQ(list["scenes"][0]["replays"].size(), 4U) << "nothing is the fourth: no contact is touched";
}

TEST_F(ReplayCommand, TellsWhenTwoReplaysPart) {
  if (!installed("ode")) GTEST_SKIP() << "ode is not installed";
  const json scenes = replay("cubes-3 box-pile --stepper nothing --stepper exact --parting --steps 300");
  EXPECT_TRUE(replay_of(scenes[0], "nothing")["parts_s"].is_null()) << "what falls freely falls alike";
  EXPECT_GT(replay_of(scenes[1], "exact")["parts_s"].get<double>(), 0.2) << scenes[1].dump();
  done("run --set paper/monotone/exp1 --trials 1 --solver lemke --store s.db");
  done("report s.db --replay made --out report");
  EXPECT_EQ(json::parse(read("report/summary.json"))["replay"], scenes);
  expect_mistake("replay my-robot --model robot.xml --stepper exact --parting --out made");
  expect_mistake("replay 'stack{nudge=1e-9}' --stepper exact --parting --out aside");
  EXPECT_TRUE(contains(read("err"), "'nudge' given twice")) << read("err");
  EXPECT_FALSE(fs::exists(folder_ / "aside")) << "it is refused before a step is made";
}

TEST_F(ReplayCommand, AStepperOfBodiesRefusesJoints) {
  if (!installed("mujoco")) GTEST_SKIP() << "mujoco is not installed";
  const std::string end = replay("hand --stepper soft_step --steps 5")[0]["replays"][0]["end"];
  EXPECT_TRUE(contains(end, "refused: it knows free bodies only, and the scene has joints")) << end;
  const std::string table = run("replay hand --stepper soft_step --stepper exact --steps 5 --out made").out;
  EXPECT_TRUE(contains(table, "  time for 1 s")) << "the reason takes no column's place: " << table;
  EXPECT_TRUE(contains(table, "\nsoft_step: refused: it knows")) << table;
}

TEST_F(ReplayCommand, WritesPageAndTablesAndTheSameAgain) {
  if (!installed("ode")) GTEST_SKIP() << "ode is not installed";
  const std::string command =
      "replay card-house gripper --solver auto --solver 'psor{max_iterations=5}' --engine-solver --steps 40 --out made";
  const std::string out = done(command);
  EXPECT_TRUE(contains(out, "card-house, 40 steps of 0.005 s in ODE:\n"));
  const std::string page = result("index.html");
  const json document = document_of(page);
  EXPECT_EQ(document["kind"], "view");
  ASSERT_EQ(document["replays"].size(), 2U);
  for (const json& replay : document["replays"]) {
    ASSERT_EQ(replay["films"].size(), 3U);
    for (const json& film : replay["films"]) EXPECT_EQ(film["frames"].size(), 21U);  // every second step, and the last
    EXPECT_TRUE(contains(out, replay["conclusion"]));
  }
  const std::string summary = result("summary.csv");
  EXPECT_EQ(std::count(summary.begin(), summary.end(), '\n'), 1 + 2 * 4);

  // What is there is not stepped again: without the engines' programs the same command gives the same.
  setenv("LCPBENCH_WORKER_DIR", (folder_ / "").c_str(), 1);
  const ProgramRun again = run(command);
  const ProgramRun fresh_without = run(command + " --fresh");
  unsetenv("LCPBENCH_WORKER_DIR");
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(result("index.html"), page);
  EXPECT_EQ(fresh_without.exit_code, 2);
  EXPECT_NE(fresh_without.err.find("engine 'ode' is not available"), std::string::npos) << fresh_without.err;
  // What has lost its frames is stepped again.
  for (const fs::directory_entry& file : fs::directory_iterator(folder_ / "made" / "steps")) {
    if (file.path().extension() == ".scenes") fs::remove(file.path());
  }
  EXPECT_EQ(run(command).exit_code, 0);
  EXPECT_EQ(page_without_times(result("index.html")), page_without_times(page));
  EXPECT_EQ(run(command + " --fresh").exit_code, 0);
  EXPECT_EQ(page_without_times(result("index.html")), page_without_times(page));
  EXPECT_EQ(without_times(result("summary.csv")), without_times(summary));
}

TEST_F(ReplayCommand, ItsFilmsAndNumbersBecomeAPartOfTheReport) {
  if (!installed("ode")) GTEST_SKIP() << "ode is not installed";
  done("run --set paper/monotone/exp1 --trials 2 --solver lemke --store s.db");
  const ProgramRun without = run("report s.db --replay made --out report");
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_NE(without.err.find("made/replays.json: cannot be read; `lcpbench replay ... --out made` writes it"),
            std::string::npos)
      << without.err;

  done("replay card-house gripper --solver auto --engine-solver --steps 20 --out made");
  const ProgramRun output = run("report s.db --replay made --out report");
  ASSERT_EQ(output.exit_code, 0) << output.err;
  const json document = document_of(read_file(folder_ / "report/report.html"));
  ASSERT_EQ(document["replays"].size(), 2U);
  EXPECT_EQ(document["replays"], document_of(result("index.html"))["replays"]);
  const std::string table = read_file(folder_ / "report/tables/replay.csv");
  EXPECT_EQ(table.substr(0, table.find('\n')), result("summary.csv").substr(0, table.find('\n')));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 1 + 2 * 3);
  const json summary = json::parse(read_file(folder_ / "report/summary.json"));
  EXPECT_EQ(summary["replay"][1]["scene"], "gripper");
  EXPECT_EQ(summary["replay"][1]["replays"][0]["survived"], 20);

  std::ofstream(folder_ / "made/replays.json") << "{\"format\": \"lcpbench-replays\", \"version\": 1}";
  EXPECT_EQ(run("report s.db --replay made --out report").exit_code, 2);
}

// The engine of a scene with joints is one that has joints; energy is left to scenes without motors.
TEST_F(ReplayCommand, ScenesWithJointsAreReplayed) {
  for (const std::string engine : {"", "mujoco", "dart"}) {
    if (!installed(engine.empty() ? "mujoco" : engine)) continue;
    const std::string of_engine = engine.empty() ? "" : " --engine " + engine;
    const json scene = replay("hand --solver auto --engine-solver --steps 40" + of_engine)[0];
    EXPECT_EQ(scene["engine"], engine == "dart" ? "DART" : "MuJoCo");
    const json& replays = scene["replays"];
    ASSERT_EQ(replays.size(), 3U);
    EXPECT_EQ(replays[0]["survived"], 40) << scene.dump();
    EXPECT_GT(replays[0]["steps_with_contacts"].get<int>(), 20);
    EXPECT_EQ(replays[0]["claimed_solved"], replays[0]["steps_with_contacts"]);
    EXPECT_TRUE(replays[0]["energy_rise_j"].is_null());
    EXPECT_LT(replays[0]["deepest_m"].get<double>(), 0.1);
    const json energies = document_of(result("index.html"))["replays"][0]["films"][0]["curves"]["energy_j"];
    EXPECT_TRUE(std::all_of(energies.begin(), energies.end(), [](const json& energy) { return energy.is_null(); }));
  }
}

TEST_F(ReplayCommand, NoContactAtAllIsTheLastRowOfEveryComparison) {
  if (!installed("ode")) GTEST_SKIP() << "ode is not installed";
  for (const std::string asked : {"--engine-solver", "--stepper nothing --stepper soft_step"}) {
    EXPECT_TRUE(contains(done("replay cubes-3 " + asked + " --steps 60 --out made"), "\nnothing "));
    const std::string summary = result("summary.csv");
    EXPECT_EQ(std::count(summary.begin(), summary.end(), '\n'), 3) << summary;
    EXPECT_EQ(summary.find("\ncubes-3,ODE,nothing,60,"), summary.rfind("\ncubes-3,")) << summary;
    const json view = document_of(result("index.html"))["replays"][0];
    EXPECT_EQ(view["films"].size(), 1U);
    EXPECT_GT(replay_of(view, "nothing")["drift_m"].get<double>(), 0.4) << "half a square of 0.3 s, times g";
  }
}

// The method is of first order: against steps a sixteenth as long, the error of steps a quarter as long is a quarter.
TEST_F(ReplayCommand, AQuarterOfTheStepHasAQuarterOfTheError) {
  if (!installed("ode")) GTEST_SKIP() << "ode is not installed";
  const auto frames = [&](int divide) {
    const std::string out = "divide-" + std::to_string(divide);
    done("replay 'slopes{divide=" + std::to_string(divide) + "}' --solver 'cone_ipm{cone=true}' --steps " +
         std::to_string(60 * divide) + " --out " + out);
    const json list = json::parse(read(out + "/replays.json"));
    return ScenesFile(folder_ / out / "steps" / list["scenes"][0]["replays"][0]["file"].get<std::string>());
  };
  const double whole = error_of(frames(1), frames(16));
  const double quarter = error_of(frames(4), frames(64));
  EXPECT_GT(whole, 1e-4);
  EXPECT_GT(whole / quarter, 3) << whole << " m, then " << quarter << " m";
  EXPECT_LT(whole / quarter, 6) << whole << " m, then " << quarter << " m";
}

// Else the next run would take the replay for complete.
TEST_F(ReplayCommand, ATrackWhoseFramesCannotBeWrittenHasNoEnd) {
  const fs::path program = fs::path(LCPBENCH_PROGRAM).parent_path() / "lcpbench-capture-ode";
  if (!installed("ode") || !fs::exists("/dev/full")) GTEST_SKIP() << "ode or /dev/full is not installed";
  fs::create_symlink("/dev/full", folder_ / "frames");
  const std::string command = "cd '" + std::string(folder_ / "") + "' && '" + program.string() +
                              "' stack '' 1 3 frames exact track.csv '' '' '' 2> /dev/null";
  EXPECT_NE(std::system(command.c_str()), 0);
  EXPECT_TRUE(fs::exists(folder_ / "track.csv"));
  EXPECT_FALSE(is_complete_track(folder_ / "track.csv"));
}

TEST_F(ReplayCommand, AForeignSolverStepsInItsWorkerAndOneThatRefusesEndsTheReplay) {
  if (!installed("ode")) GTEST_SKIP() << "ode is not installed";
  const json scenes = replay("stack bouncing-balls --solver ode_quickstep --solver active_set --steps 40");
  const json& replays = scenes[0]["replays"];
  EXPECT_EQ(replays[0]["survived"], 40) << replays.dump();
  EXPECT_TRUE(replays[1]["survived"].is_null()) << replays.dump();
  EXPECT_TRUE(replays[1]["end"].get<std::string>().starts_with("refused: ")) << replays.dump();
  const json& balls = scenes[1]["replays"][1];
  EXPECT_EQ(balls["steps_with_contacts"], 1) << "refused after the fall: " << balls.dump();
}

// A replay that is interrupted, or whose command is killed, leaves what an earlier one wrote, and no program behind.
TEST_F(ReplayCommand, AnUnfinishedReplayLeavesTheEarlierOneAndNoProgram) {
  if (!installed("ode")) GTEST_SKIP() << "ode is not installed";
  const fs::path made = folder_ / "made";
  done("replay stack --solver auto --steps 3 --out made");
  const auto contents = [&] {
    std::map<std::string, std::string> all;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(made)) {
      if (entry.is_regular_file() && entry.path().extension() != ".part") all[entry.path()] = read_file(entry.path());
    }
    return all;
  };
  const auto before = contents();
  const fs::path workers = folder_ / "workers";
  fs::create_directory(workers);
  std::ofstream(workers / "lcpbench-capture-ode") << "#!/bin/sh\necho half > \"$5\"; echo half > \"$7\"\n"
                                                  << "echo $$ > ready\nexec sleep 1000\n";
  fs::permissions(workers / "lcpbench-capture-ode", fs::perms::owner_all);
  for (const std::string signal : {"TERM", "KILL"}) {
    fs::remove(folder_ / "ready");
    const std::string script = "cd '" + std::string(folder_ / "") + "' && export LCPBENCH_WORKER_DIR=$PWD/workers; '" +
                               LCPBENCH_PROGRAM +
                               "' replay stack --solver auto --steps 3 --out made --fresh >out 2>err & "
                               "until [ -s ready ]; do sleep 0.02; done; kill -" +
                               signal + " $!; wait $!";
    EXPECT_EQ(WEXITSTATUS(std::system(script.c_str())), signal == "TERM" ? 3 : 128 + SIGKILL);
    EXPECT_FALSE(runs_on(folder_ / "ready")) << signal;
    EXPECT_EQ(contents(), before) << signal;
  }
}

}  // namespace
}  // namespace lcpbench::replay_test
