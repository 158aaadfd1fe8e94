#include <regex>

#include <gtest/gtest.h>

#include "core/io/scenes_file.h"
#include "study/report/decision.h"
#include "study/report/model_choice.h"
#include "study/report/model_error.h"
#include "study/report/report.h"
#include "study/report/scenes.h"
#include "tests/support/program_run.h"
#include "tests/support/synthetic_store.h"

namespace lcpbench {
namespace {

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++count;
  return count;
}

class ScenesReportTest : public testing::Test {
 protected:
  ScenesReportTest() : made_(folder_ / "s.db"), good_(made_.solver("good")), liar_(made_.solver("liar")) {}

  /// @param lies  whether `liar` answers wrongly; it is fast
  void add(const std::string& set, const std::string& kind, int steps, bool lies = true) {
    for (int step = 0; step < steps; ++step) {
      made_.problem(set, step, {{good_, {.time_s = 2e-3}}, {liar_, {.error = lies ? 0.5 : 1e-12, .time_s = 1e-5}}}, 20,
                    "solvable", kind);
    }
  }

  std::string page() {
    write_report(made_.store(), folder_ / "out");
    return read_file(folder_ / "out/report.html");
  }

  ScratchFolder folder_;
  SyntheticStore made_;
  std::int64_t good_;
  std::int64_t liar_;
};

TEST_F(ScenesReportTest, ScenesAreTheFirstRowsAndNoRandomProblems) {
  add("scene/stack/ode", "scene", 40);
  add("scene/box-pile/bullet", "scene", 40);
  add("scene/hand/dart", "contact", 40);
  add("scene/wedge/ode", "scene", 40);
  add("paper/copositive/exp1", "contact", 40, false);
  const Summary summary = summarize(made_.store());
  const auto situations = report::decide(summary);
  std::vector<std::string> titles;
  for (const auto& situation : situations) titles.push_back(situation.title);
  EXPECT_EQ(titles, (std::vector<std::string>{"A robot's step", "Stacks and walls", "Piles", "Other scenes",
                                              "Frictionless", "Frictional", "Ill-conditioned"}));
  for (std::size_t i = 0; i < 4; ++i) {
    ASSERT_EQ(situations[i].sets.size(), 1U);
    ASSERT_TRUE(situations[i].recommended.has_value());
    EXPECT_EQ(summary.solvers[situations[i].contenders[0].solver].name, "good") << titles[i];
  }
  EXPECT_EQ(summary.sets[situations[0].sets[0]].name, "scene/hand/dart");
  ASSERT_EQ(situations[5].sets.size(), 1U);
  EXPECT_EQ(summary.solvers[situations[5].contenders[0].solver].name, "liar");
}

TEST_F(ScenesReportTest, AStoreWithoutScenesHasTheRowsOfRandomProblemsAlone) {
  add("paper/copositive/exp1", "contact", 40);
  EXPECT_EQ(report::decide(summarize(made_.store())).size(), 3U);
  EXPECT_EQ(page().find("id=\"scenes\""), std::string::npos);
}

/// A step that is not proven solvable, as where an offset is negative, must not push its set out of the table.
TEST_F(ScenesReportTest, SetsThatAreNotAllProvenSolvableCount) {
  add("scene/stack/ode", "scene", 40);
  made_.problem("scene/stack/bullet", 0, {{good_, {}}, {liar_, {}}}, 20, "", "scene");
  made_.problem("scene/stack/bullet", 1, {{good_, {.error = 0.5}}, {liar_, {.error = 0.5}}}, 20, "", "scene");
  EXPECT_EQ(report::decide(summarize(made_.store()))[0].sets.size(), 2U);
}

TEST_F(ScenesReportTest, TheFirstSentenceNamesTheSolverForScenesWithSharesAndTimes) {
  add("scene/stack/ode", "scene", 40);
  add("scene/hand/dart", "contact", 3, false);
  const std::string text = page();
  EXPECT_NE(text.find("<p class=\"answer\">For captured scenes: a robot's step: no solver is recommended: too few to "
                      "say: 3 problems; the report needs 35; all 3 are solved by 2 of 2 solvers, the fastest of them "
                      "liar in a median of 10.0 µs; that shows a share of at least 43.9 % (95 %); stacks and walls: "
                      "<code>good</code>, which solved 100 % (91.2–100 %) of 40 problems in a median of 2.00 "
                      "ms.</p>"),
            std::string::npos)
      << text.substr(text.find("class=\"answer\""), 500);
  EXPECT_NE(text.find("Captured problems."), std::string::npos);
  EXPECT_EQ(text.find("no such problems in this study"), std::string::npos);
}

/// A false claim is named wherever a solver is recommended.
TEST_F(ScenesReportTest, TheFirstSentenceNamesTheFalseClaimsOfWhatItRecommends) {
  for (int step = 0; step < 600; ++step) {
    made_.problem("scene/stack/ode", step, {{good_, {.error = step == 0 ? 0.5 : 1e-12}}}, 20, "solvable", "scene");
  }
  EXPECT_NE(page().find("in a median of 1.00 ms (it said solved and was wrong on 0.17 %).</p>"), std::string::npos);
}

TEST_F(ScenesReportTest, EveryFamilyHasItsPictureAndATableOfItsEngines) {
  add("scene/stack/ode", "scene", 4);
  add("scene/stack/bullet", "scene", 4);
  add("scene/humanoid-lying/mujoco", "contact", 4, false);
  const std::string text = page();
  const std::string section = text.substr(text.find("<section id=\"scenes\">"), text.find("</section>"));
  EXPECT_EQ(count_of(section, "<figcaption>"), 2U);
  EXPECT_NE(section.find("stack, step 160 of Bullet"), std::string::npos);
  EXPECT_NE(section.find("8 steps: bullet, ode"), std::string::npos);
  EXPECT_NE(section.find(">bullet</a></th>"), std::string::npos);
  EXPECT_NE(section.find("0 of 4<small><span class=\"bad\">4 wrong</span>, 10.0 µs"), std::string::npos) << section;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/figures/scene_stack_bullet.scene.svg"));
}

/// Two bars: what is the solver's is no part of the model's error, and both are 90th percentiles of the solved steps.
TEST_F(ScenesReportTest, TheModelsErrorAndTheSolversAreOnePicture) {
  const auto cone = made_.solver("round", "cone=true");
  for (int step = 0; step < 21; ++step) {
    const double scale = step < 9 ? 1e-3 : step == 20 ? 1000 : 1;  // the 90th percentile is of the middle ones
    const MadeAnswer pyramid{
        .time_s = 2e-3, .solver_error_m_per_s = 3e-13 * scale, .model_error_m_per_s = 0.25 * scale};
    const MadeAnswer round{.time_s = 4e-3, .solver_error_m_per_s = 5e-9, .model_error_m_per_s = 5e-9};
    const MadeAnswer wrong{.error = 0.5, .solver_error_m_per_s = 7, .model_error_m_per_s = 7};
    made_.problem("scene/stack/ode", step, {{good_, pyramid}, {cone, round}, {liar_, wrong}}, 20, "solvable", "scene");
  }
  made_.problem("paper/copositive/exp1", 0, {{good_, {.solver_error_m_per_s = 9, .model_error_m_per_s = 9}}}, 20);
  const Summary summary = summarize(made_.store());
  const report::ModelErrors errors = report::model_errors(summary);
  EXPECT_EQ(errors.steps, 21);
  ASSERT_EQ(errors.points.size(), 2U) << "wrong answers and random problems have no bar";
  EXPECT_EQ(summary.solvers[errors.points[0].solver].name, "good");
  EXPECT_EQ(errors.points[0].steps, 21);
  EXPECT_EQ(errors.points[0].time_s, 2e-3);
  EXPECT_EQ(errors.points[0].total_m_per_s, 0.25);
  EXPECT_EQ(errors.points[0].solver_m_per_s, 3e-13);
  EXPECT_EQ(errors.points[1].total_m_per_s, errors.points[1].solver_m_per_s);

  const std::string words = "The heights rank no solvers: each is over the steps that its own solver solved";
  const std::string text = page();
  EXPECT_NE(text.find(words), std::string::npos) << text.substr(text.find("id=\"model-error\""), 1200);
  const std::string picture = read_file(folder_ / "out/figures/scenes.model-error.svg");
  EXPECT_NE(picture.find(words), std::string::npos);
  EXPECT_EQ((text + picture).find("least total error"), std::string::npos);
  // Of each solver the whole bar and the shaded one, which are of one height where no part is the model's.
  std::vector<double> tops;
  const std::regex bar("M[0-9.]+ ([0-9.]+)h8v");
  for (auto it = std::sregex_iterator(picture.begin(), picture.end(), bar); it != std::sregex_iterator(); ++it) {
    tops.push_back(std::stod((*it)[1]));
  }
  ASSERT_EQ(tops.size(), 4U);
  EXPECT_LT(tops[0], tops[2]);
  EXPECT_LT(tops[2], tops[1]);
  EXPECT_EQ(tops[2], tops[3]);
}

TEST_F(ScenesReportTest, WithoutModelErrorsThereIsNoSuchPicture) {
  add("scene/stack/ode", "scene", 4);
  EXPECT_EQ(page().find("id=\"model-error\""), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/figures/scenes.model-error.svg"));
}

/// The first model whose measured error is small enough is chosen, whatever the verdict of its answer; a step that no
/// model brings there is named.
TEST_F(ScenesReportTest, TheModelThatAStepNeedsIsTheFirstWithinTheError) {
  const auto pyramid = made_.solver("auto");
  const auto cone = made_.solver("cone_ipm", "cone=true");
  const auto step = [&](int trial, double pyramid_error, MadeAnswer round) {
    round.time_s = 3e-3;
    made_.problem("scene/stack/ode", trial,
                  {{pyramid, {.time_s = 1e-3, .model_error_m_per_s = pyramid_error}}, {cone, round}}, 20, "solvable",
                  "scene");
  };
  step(0, 1e-3, {.model_error_m_per_s = 1e-12});
  step(1, 0.2, {.model_error_m_per_s = 1e-12});
  step(2, 0.2, {.error = 0.5, .model_error_m_per_s = 9e-4});                                     // rough, and enough
  step(3, 0.2, {.claim = Claim::kIterationLimit, .error = 0.5, .model_error_m_per_s = 0.0321});  // the better of two
  step(4, Errors::kNone, {.error = Errors::kNone});
  made_.problem("paper/copositive/exp1", 0, {{pyramid, {.model_error_m_per_s = 9}}}, 20);

  const Summary summary = summarize(made_.store());
  const report::ModelChoices choices = report::model_choices(summary);
  ASSERT_EQ(choices.steps.size(), 4U) << "a step without a known error, and random problems, are no part of it";
  EXPECT_EQ(choices.unknown, 1);
  EXPECT_EQ(choices.met(), 3);
  ASSERT_EQ(choices.solvers.size(), 2U);
  EXPECT_EQ(choices.chosen(choices.solvers[0]), 1);
  EXPECT_EQ(choices.chosen(choices.solvers[1]), 2);
  EXPECT_EQ(choices.steps[1].spent_s, 4e-3);
  EXPECT_EQ(choices.steps[1].time_s, 3e-3);
  EXPECT_FALSE(choices.steps[3].met);
  EXPECT_EQ(choices.steps[3].error_m_per_s, 0.0321);

  const std::string text = page();
  const std::string part = text.substr(text.find("id=\"model-choice\""), 2500);
  EXPECT_NE(part.find("3 of 4 steps are within it (75.0 %; 95 % interval"), std::string::npos) << part;
  EXPECT_NE(part.find("<code>scene/stack/ode#3</code> (3.2e-02 m/s)"), std::string::npos) << part;
  EXPECT_EQ(part.find("No step misses it"), std::string::npos);
  EXPECT_NE(
      read_file(folder_ / "out/tables/model_choice.csv").find("scene/stack/ode,3,cone_ipm{cone=true},0.0321,false"),
      std::string::npos);
  const auto json = nlohmann::json::parse(read_file(folder_ / "out/summary.json"))["models"];
  EXPECT_EQ(json["met"], 3);
  EXPECT_EQ(json["missed"][0]["problem"], "scene/stack/ode#3");
}

TEST_F(ScenesReportTest, WithoutAFinerModelThereIsNoChoice) {
  const auto pyramid = made_.solver("auto");
  made_.problem("scene/stack/ode", 0, {{pyramid, {.model_error_m_per_s = 1e-12}}}, 20, "solvable", "scene");
  EXPECT_EQ(page().find("id=\"model-choice\""), std::string::npos);
}

TEST(ScenePictureTest, DrawsEveryShapeOfTheReferenceAndLeavesOutOthers) {
  const ScratchFolder folder;
  const std::string file = (folder / "made.scenes").string();
  ScenesHeader header{.scene = "<made>", .engine = "none", .gravity = {0, 0, -9.81}};
  header.shapes = {
      {-1, "plane", {0, 0, 1, 0}}, {0, "box", {0.2, 0.3, 0.1}}, {1, "sphere", {0.2}}, {2, "capsule", {0.1, 0.3}},
      {3, "cylinder", {0.1, 0.2}}, {0, "mesh", {1, 2}},         {0, "box", {1}},      {7, "sphere", {1}}};
  SceneStep step;
  step.problem = Problem("made", RigidScene{.bodies = {RigidBody{}}, .contacts = {RigidContact{}}});
  for (double x = 0; x < 4; ++x) step.poses.push_back({x, 0, 0.5, 1, 0, 0, 0});
  {
    ScenesWriter writer(file, header);
    writer.add(step);
    step.step = 1;
    step.poses[1] = {1, 0, 0.7, 1, 0, 0, 0};
    writer.add(step);
    writer.close();
  }
  const auto picture = report::scene_picture("file:" + file);
  ASSERT_TRUE(picture.has_value());
  EXPECT_EQ(picture->alternative, "<made>, step 1 of none: the scene from the side.");
  EXPECT_NE(picture->svg.find("&lt;made&gt;, step 1"), std::string::npos);
  const std::size_t still = picture->svg.find("<g class=\"c-grey\"");
  const std::size_t moving = picture->svg.find("<g class=\"c-plain\"");
  ASSERT_NE(moving, std::string::npos);
  EXPECT_EQ(count_of(picture->svg.substr(still, moving - still), "<path"), 4U);  // plane, box, capsule, cylinder
  EXPECT_EQ(count_of(picture->svg.substr(moving, picture->svg.find("</g>", moving) - moving), "<path"), 1U);
  EXPECT_EQ(picture->svg.find("nan"), std::string::npos);
}

TEST(ScenePictureTest, WithoutAFileOrPosesThereIsNone) {
  EXPECT_FALSE(report::scene_picture("file:/nowhere/gone.scenes").has_value());
  EXPECT_FALSE(report::scene_picture("scene/nobody/ode").has_value());
  EXPECT_FALSE(report::scene_picture("paper/monotone/exp1").has_value());
}

}  // namespace
}  // namespace lcpbench
