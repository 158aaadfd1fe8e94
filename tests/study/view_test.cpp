// Steps and replays as the page shows them in 3D: where contacts are, the numbers of answers, and the command.
#include "study/view/view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/problem_io.h"
#include "generators/scenes/scenes.h"
#include "tests/support/page_document.h"
#include "tests/support/program_test.h"

namespace lcpbench::view_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using nlohmann::json;

const CollectedScene& collected(const std::string& name) {
  const auto& all = collected_scenes();
  return *std::find_if(all.begin(), all.end(), [&](const CollectedScene& scene) { return scene.name == name; });
}

/// A unit cube, turned about two axes, that touches the floor with two of its corners.
struct Cube {
  ScenesHeader header;
  SceneStep step;
  Eigen::Isometry3d pose =
      Eigen::Translation3d(0.3, -2, std::sqrt(0.5)) * Eigen::AngleAxisd(M_PI / 4, Vector3d::UnitY());
  RigidScene scene;

  Cube() {
    header.shapes = {{0, "box", {0.5, 0.5, 0.5}}, {-1, "plane", {0, 0, 1, 0}}};
    const Eigen::Quaterniond q(pose.rotation());
    const Vector3d at = pose.translation();
    step.poses = {{at.x(), at.y(), at.z(), q.w(), q.x(), q.y(), q.z()}};
    scene.bodies.push_back({.mass = 1, .position = at});
    for (const double y : {-0.5, 0.5}) {
      const Vector3d corner = pose * Vector3d(0.5, y, -0.5);
      scene.contacts.push_back({.point = corner, .mu = 0.5, .edges = 4});
    }
  }};

/// Two frames, in which the second of two bodies falls by a metre.
TEST(ReplayView, KeepsThePosesOfWhatDoesNotMoveOnce) {
  const ScratchFolder folder;
  Cube cube;
  cube.step.problem = Problem("cube", cube.scene);
  cube.header.scene = "fall";
  const std::string file = (folder / "fall.scenes").string();
  {
    ScenesWriter writer(file, cube.header);
    cube.step.poses.insert(cube.step.poses.begin(), {0, 0, 0, 1, 0, 0, 0});
    writer.add(cube.step);
    cube.step.step = 10;
    cube.step.time = 0.05;
    cube.step.poses[1][2] -= 1;
    writer.add(cube.step);
    writer.close();
  }
  ReplayedFiles replays;
  replays.scene = {"fall", "ODE", 0.005, 400, false, {{"auto", {}, ""}}};
  for (std::int64_t step = 0; step < 400; ++step) {
    replays.scene.replays[0].steps.push_back(
        {step, 0.005 * static_cast<double>(step), 4, "solved", 1, 1e-3, step == 7 ? 0.25 : 0.0, std::nan("")});
  }
  replays.frames.push_back(std::make_unique<ScenesFile>(file));
  const json view = replay_view(replays);
  const json& film = view["films"][0];
  EXPECT_EQ(film["moving"], json({1}));
  EXPECT_EQ(film["still"][0], json({0, 0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(film["still"][1], nullptr);
  EXPECT_EQ(film["steps"], json({0, 10}));
  EXPECT_NEAR(film["frames"][0][2].get<double>() - film["frames"][1][2].get<double>(), 1, 1e-4);
  EXPECT_EQ(film["curves"]["drift_m"].size(), 150u);
  const std::vector<double> drift = film["curves"]["drift_m"];
  EXPECT_EQ(*std::max_element(drift.begin(), drift.end()), 0.25);  // of one step of many
  EXPECT_EQ(film["curves"]["slip_m"][0], nullptr);
  EXPECT_EQ(view["replays"][0]["survived"], 7);
}

class ViewCommand : public ProgramTest {
 protected:
  void copy_of(const std::string& scene, const std::string& name) { write(name, std::string(collected(scene).bytes)); }
  /// A scenes file of one step.
  void write_scene(const std::string& file, const ScenesHeader& header, const SceneStep& step) {
    ScenesWriter writer((folder_ / file).string(), header);
    writer.add(step);
    writer.close();
  }
};

TEST_F(ViewCommand, HasTheNumbersOfSolve) {
  copy_of("scene/slope/ode", "slope.scenes");
  const std::string solvers =
      " --solver auto --solver 'psor{max_iterations=20}' --solver 'cone_ipm{cone=true,max_iterations=3}'";
  const auto file = open_collected(collected("scene/slope/ode"));
  const std::string step = "'slope.scenes#" + std::to_string(file->step_number(file->count() / 2)) + "'";
  const json answers = run_json("view " + step + solvers)["scenes"][0]["answers"];
  const json solved = run_json("solve " + step + solvers);
  ASSERT_EQ(answers.size(), 3u);
  for (const json& answer : answers) {
    const auto found = std::find_if(solved.begin(), solved.end(), [&](const json& row) {
      return answer["solver"].get<std::string>().starts_with(row["solver"].get<std::string>());
    });
    ASSERT_NE(found, solved.end()) << answer["solver"];
    const json& row = *found;
    for (const char* same : {"claim", "verdict", "model"}) EXPECT_EQ(answer[same], row[same]);
    EXPECT_EQ(answer["model"], row["solver"] == "cone_ipm" ? "cone" : "pyramid");
    const double error = row["errors"]["velocity_residual_m_per_s"];
    EXPECT_EQ(answer["error_m_per_s"], error);
    EXPECT_EQ(answer["error_relative"], row["errors"]["velocity_residual_relative"]);
    EXPECT_EQ(answer["violation_m_per_s"], row["errors"]["violation_m_per_s"]);
    const std::vector<double> residuals = answer["residuals"];
    EXPECT_NEAR(*std::max_element(residuals.begin(), residuals.end()), error, 1e-5 * error + 1e-13);
    const std::vector<double> z = row["z"];
    const std::size_t contacts = residuals.size();
    for (std::size_t c = 0; c < contacts; ++c) {
      const json& impulse = answer["impulses"][c];
      const double scale = 1e-5 * std::abs(z[c]) + 1e-12;
      EXPECT_NEAR(impulse[0], z[c], scale);
      const std::size_t first = contacts + 4 * c;  // the directions t1, t2, -t1, -t2
      EXPECT_NEAR(impulse[1], z[first] - z[first + 2], scale);
      EXPECT_NEAR(impulse[2], z[first + 1] - z[first + 3], scale);
    }
    const std::vector<double> velocity = row["velocity"];
    for (std::size_t i = 0; i < velocity.size(); ++i) {
      EXPECT_NEAR(answer["body_velocities"][i / 6][i % 6], velocity[i], 1e-5 * std::abs(velocity[i]) + 1e-12);
    }
  }
}

/// The residual at each contact is that of the verdict with compliance and offsets, too, and in all models of friction:
/// a right answer has no colour of a wrong one.
TEST_F(ViewCommand, ColoursSoftContactsAndTheConvexModelByTheErrorOfTheirVerdict) {
  RigidScene scene = Cube().scene;
  scene.bodies[0].linear_velocity = {0.7, 0.2, -1};
  scene.bodies[0].angular_velocity = {0.1, -0.4, 0.3};
  for (RigidContact& contact : scene.contacts) {
    contact.b = -0.25;
    contact.compliance_n = 0.5;
    contact.compliance_t = 0.25;
    contact.offset_t = {0.125, -0.0625};
  }
  SceneStep step;
  step.problem = Problem("soft", scene);
  write_scene("soft.scenes", {.scene = "soft"}, step);
  const json answers = run_json(
      "view 'soft.scenes#0' --solver auto --solver 'psor{max_iterations=2}' "
      "--solver 'cone_ipm{cone=true,max_iterations=2}' --solver 'cone_ipm{cone=true,slip=none}' "
      "--solver 'cone_ipm{cone=true,slip=none,max_iterations=2}'")["scenes"][0]["answers"];
  ASSERT_EQ(answers.size(), 5u);
  for (const json& answer : answers) {
    const double error = answer["error_m_per_s"];
    const std::vector<double> residuals = answer["residuals"];
    // The page's numbers have five digits, and their rounding beside speeds of 1 m/s is far below 1e-13.
    EXPECT_NEAR(*std::max_element(residuals.begin(), residuals.end()), error, 1e-5 * error + 1e-13) << answer["solver"];
  }
}

/// Of a robot, whose coordinates do not show where its contacts are.
TEST_F(ViewCommand, PutsContactsOfRobotsWhereTheStepTells) {
  Cube cube;
  cube.step.problem = Problem("cube", contact_problem(cube.scene));
  cube.step.contact_frames = {{1, 2, 3, 0, 0, 1, 1, 0, 0}, {}};
  write_scene("frames.scenes", cube.header, cube.step);
  EXPECT_EQ(ScenesFile((folder_ / "frames.scenes").string()).read(0).contact_frames, cube.step.contact_frames);
  const json contacts = run_json("view 'frames.scenes#0' --solver auto")["scenes"][0]["contacts"];
  EXPECT_EQ(contacts["points"], json::parse("[[1, 2, 3], null]"));
  EXPECT_EQ(contacts["axes"], json::parse("[[[0, 0, 1], [1, 0, 0], [0, 1, 0]], null]"));
  cube.step.contact_frames.pop_back();
  EXPECT_THROW(scenes_line(cube.step), InputError);
}

TEST_F(ViewCommand, DrawsEachContactOfTheCollectedRobots) {
  for (const char* name : {"scene/quadruped-trotting/mujoco", "scene/quadruped-trotting/dart", "scene/hand/dart",
                           "scene/hand/mujoco", "scene/humanoid-falling/mujoco"}) {
    const auto file = open_collected(collected(name));
    const SceneStep step = file->read(file->count() / 2);
    ASSERT_FALSE(step.contact_frames.empty()) << name;
    for (std::size_t c = 0; c < step.contact_frames.size(); ++c) {
      EXPECT_EQ(!step.contact_frames[c].empty(), step.problem.contact()->edges[c] > 0) << name << " contact " << c;
    }
  }
}

TEST_F(ViewCommand, WritesOnePageInWhichNoNameIsMarkup) {
  RigidScene scene = Cube().scene;
  const std::string name = "</script><script>alert('1')</script>\"<!--";
  SceneStep step;
  step.problem = Problem(name, scene);
  step.contact_ids = {name, "b"};
  write_scene("names.scenes", {.scene = name, .engine = name, .shapes = {{0, name, {1}}}}, step);
  done("view 'names.scenes#0' --out page.html");
  const std::string page = read("page.html");
  EXPECT_EQ(page.find("alert('1')</script>"), std::string::npos);
  EXPECT_EQ(page.find("@report@"), std::string::npos);
  const json document = document_of(page);
  EXPECT_EQ(document["kind"], "view");
  EXPECT_EQ(document["scenes"][0]["contacts"]["ids"][0], name);
  EXPECT_EQ(document["scenes"][0]["notes"][0], "Shapes of type " + name + " are not drawn.");
}

TEST_F(ViewCommand, SaysWhatIsWrongWithItsInput) {
  copy_of("scene/stack/ode", "stack.scenes");
  write_problem_of("lcp.json", kOneRow);
  fs::create_directories(folder_ / "empty");
  write("hull.scenes", R"({"format":"lcpbench-scenes","version":1,"scene":"s","shapes":[)"
                       R"({"body":0,"type":"hull","size":[1,2,3,4]}]})");
  const std::pair<const char*, const char*> cases[] = {
      {"none.scenes#1", "lcpbench: none.scenes: no such file\n"},
      {"stack.scenes#99999", "has no step 99999; the one before is"},
      {"stack.scenes", "name one, as 'stack.scenes#"},
      {"lcp.json", "lcp.json: is a bare LCP"},
      {"hull.scenes#0", "lcpbench: hull.scenes: line 1: shapes[0].size: 4 entries, expected three for each of 4 to 256"},
      {"empty", "replays.json: cannot be read"},
      {"'stack.scenes#0' --solver nothing", "unknown solver 'nothing'"},
      {"'stack.scenes#0' --out none/page.html", "none/page.html: cannot be written"}};
  for (const auto& [arguments, words] : cases) {
    expect_mistake(std::string("view ") + arguments);
    EXPECT_TRUE(contains(read("err"), words)) << arguments << ": " << read("err");
    EXPECT_FALSE(fs::exists(folder_ / "view.html")) << arguments;
  }
}

TEST_F(ViewCommand, TakesContactsWithoutBodiesAndWithoutContacts) {
  for (const char* text :
       {R"("kind": "contact", "v": [], "N": [], "b": [], "G": [])", R"("kind": "scene", "bodies": [], "contacts": [])",
        R"("kind": "contact", "v": [-1], "N": [[1]], "G": [[2]])"}) {
    write_problem_of("small.json", text);
    EXPECT_EQ(run_json("view small.json")["scenes"][0]["answers"][0]["verdict"], "solved") << text;
  }
}

TEST_F(ViewCommand, TheReportHasStepsWithAVerifiedAnswerAndOneThatFailed) {
  done(
      "run --set scene/stack/ode --set scene/stack/dart --set scene/wall/ode --solver auto "
      "--solver 'psor{max_iterations=20}' --solver 'psor{max_iterations=5}' --store s.db");
  Store store = Store::open_for_reading(folder_ / "s.db");
  const auto views = stored_step_views(store, 6, 100'000);
  ASSERT_EQ(views.size(), 2u);  // one of the stacks, and the wall
  for (const auto& view : views) {
    EXPECT_LE(view.dump().size(), 100'000u);
    EXPECT_EQ(view["answers"][0]["solver"], "auto");
    EXPECT_EQ(view["answers"][0]["verdict"], "solved");
    EXPECT_NE(view["answers"][1]["verdict"], "solved");
    EXPECT_GT(view["answers"][1]["error_m_per_s"], 1e-4);
  }
  EXPECT_EQ(views[0]["title"].get<std::string>().substr(0, 5), "stack");
  EXPECT_EQ(views[0]["answers"][1]["solver"], "psor{max_iterations=5}");
  EXPECT_GE(views[0]["answers"][1]["error_m_per_s"], views[1]["answers"][1]["error_m_per_s"]);
  EXPECT_EQ(stored_step_views(store, 1).size(), 1u);
  EXPECT_TRUE(stored_step_views(store, 6, 1000).empty());
}

/// From the file through the store to each place where a user reads results.
TEST_F(ViewCommand, TheReportCountsHowProblemsDifferFromTheStepsOfTheEngine) {
  Cube cube;
  cube.step.problem = Problem("cube", cube.scene);
  const std::vector<std::string> notes[] = {
      {"ropes, left out: 2", "springs: as forces: 1"}, {}, {"springs: as forces: 3", "wind, without a number"}};
  ScenesWriter writer((folder_ / "cube.scenes").string(), cube.header);
  for (cube.step.step = 0; cube.step.step < 3; ++cube.step.step) {
    cube.step.notes = notes[cube.step.step];
    writer.add(cube.step);
  }
  writer.close();
  const std::string sentence =
      "2 captured problems differ from the steps that their engines took, counted over all: ropes, left out: 2; "
      "springs: as forces: 4; wind, without a number: 1.";
  done("run --set file:cube.scenes --solver auto --store all.db");
  EXPECT_TRUE(contains(std::regex_replace(read("out"), std::regex("\\s+"), " "), sentence)) << read("out");
  done("report all.db --out report");
  EXPECT_EQ(json::parse(read("report/report.json"))["notes"], json({sentence}));
  const json counts = {{"ropes, left out", 2}, {"springs: as forces", 4}, {"wind, without a number", 1}};
  EXPECT_EQ(json::parse(read("report/summary.json"))["differences"], (json{{"problems", 2}, {"counts", counts}}));

  done("run --set 'file:cube.scenes#2' --solver auto --store one.db");
  done("merge both.db one.db all.db --mixed");
  done("report both.db --out report");
  EXPECT_EQ(json::parse(read("report/summary.json"))["differences"]["counts"]["springs: as forces"], 7);
  const json shown = run_json("view 'cube.scenes#0' --solver auto")["scenes"][0]["notes"];
  EXPECT_EQ(shown, json({"The problem differs from the step that the engine took: ropes, left out: 2; springs: as "
                         "forces: 1."}));
}

}  // namespace
}  // namespace lcpbench::view_test
