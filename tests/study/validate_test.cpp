// What a user relies on: `lcpbench validate` says that ours is wrong exactly when it is, whoever else is, and by the
// verdicts of the one evaluation.

#include "study/validate/validate.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "study/run/open_solver.h"
#include "study/run/runner.h"
#include "tests/support/program_test.h"

namespace lcpbench::validate_test {
namespace {

using nlohmann::json;

// ---- a study whose answers are made up ----

/// One body of mass 1 falling at 1 m/s on one contact. The answer is z = 1, v+ = 0.
Problem falling_body(const std::string& name) {
  ContactProblem contact;
  contact.v = Vector::Constant(1, -1.0);
  contact.N = Matrix(Matrix::Ones(1, 1));
  contact.D = Matrix(1, 0);
  contact.edges = {0};
  contact.mu = Vector::Zero(1);
  contact.inertia = DenseInertia{Matrix::Identity(1, 1)};
  return {name, contact};
}

Answer made_up(Claim claim, double z, std::optional<double> velocity = std::nullopt) {
  Answer answer;
  answer.claim = claim;
  answer.z = Vector::Constant(1, z);
  if (velocity) answer.velocity = Vector::Constant(1, *velocity);
  return answer;
}

const Answer kRightAnswer = made_up(Claim::kSolved, 1.0);
const Answer kWrongAnswer = made_up(Claim::kSolved, 0.0);
const Answer kGaveUp = made_up(Claim::kNumericalFailure, 0.0);
const Answer kSolvedUnclaimed = made_up(Claim::kIterationLimit, 1.0);
const Answer kDenied = made_up(Claim::kUnsolvable, 0.0);
const Answer kRefused = made_up(Claim::kUnsupported, 0.0);
const Answer kOtherVelocity = made_up(Claim::kSolved, 1.0, 5e-5);  // within the tolerance of the verdict

class Player final : public TimedSolver {
 public:
  explicit Player(const std::vector<Answer>& answers) : answers_(answers) {}
  void run(const Problem& problem, const TimedRequest&, TimedAnswer& result) override {
    result = {};
    result.answer = answers_.at(std::stoul(problem.name()));
  }

 private:
  const std::vector<Answer>& answers_;
};

/// The answers of a native solver and of a reference to the same problem, one pair after the other.
class PlayedStudy {
 public:
  explicit PlayedStudy(const std::vector<std::pair<Answer, Answer>>& answers,
                       Problem (*problem)(const std::string& name) = falling_body) {
    std::vector<Problem> problems;
    for (std::size_t i = 0; i < answers.size(); ++i) {
      problems.push_back(problem(std::to_string(i)));
      native_.push_back(answers[i].first);
      reference_.push_back(answers[i].second);
    }
    const auto count = static_cast<std::int64_t>(problems.size());
    study_.sets = {{std::make_shared<GivenProblems>("given", std::move(problems)), count}};
    study_.solvers.push_back(given_solver("lemke", [this] { return std::make_unique<Player>(native_); }));
    study_.solvers.push_back(given_solver("siconos_lemke", [this] { return std::make_unique<Player>(reference_); }));
  }

  void set_model(FrictionModel of_native) { study_.solvers[0].row.friction = of_native; }

  Validation validate() const {
    const ScratchFolder folder;
    Store store = Store::open_for_writing(folder / "s.db");
    run_study(study_, store, {});
    return lcpbench::validate(study_, store);
  }

 private:
  std::vector<Answer> native_;
  std::vector<Answer> reference_;
  Study study_;
};

json pair_with(const Validation& validation, const std::string& reference) {
  for (const auto& pair : validation.pairs) {
    if (pair["reference"] == reference) return pair;
  }
  return json::object();
}

/// Every line of the table in docs/howto/compare.md.
TEST(ValidateTest, CountsEveryOutcomeOnce) {
  const Validation validation = PlayedStudy({{kRightAnswer, kRightAnswer},
                                             {kRightAnswer, kWrongAnswer},
                                             {kRightAnswer, kGaveUp},
                                             {kWrongAnswer, kRightAnswer},
                                             {kWrongAnswer, kWrongAnswer},
                                             {kWrongAnswer, kGaveUp},
                                             {kGaveUp, kRightAnswer},
                                             {kGaveUp, kWrongAnswer},
                                             {kGaveUp, kGaveUp},
                                             {kRightAnswer, kRefused},
                                             {kRefused, kRightAnswer},
                                             {kSolvedUnclaimed, kRightAnswer},
                                             {kRightAnswer, kDenied}})
                                    .validate();
  EXPECT_EQ(pair_with(validation, "siconos_lemke"), json({{"set", "given"},
                                                          {"native", "lemke"},
                                                          {"reference", "siconos_lemke"},
                                                          {"compared", 11},  // what was refused is not compared
                                                          {"agree", 2},
                                                          {"native_wrong", 2},
                                                          {"reference_wrong", 2},
                                                          {"both_wrong", 1},
                                                          {"undecided", 4}}));
  const json truth = pair_with(validation, "truth");
  EXPECT_EQ(truth, json({{"set", "given"},
                         {"native", "lemke"},
                         {"reference", "truth"},
                         {"compared", 12},
                         {"agree", 6},
                         {"native_wrong", 3},
                         {"reference_wrong", 0},
                         {"both_wrong", 0},
                         {"undecided", 3}}));
  EXPECT_TRUE(validation.ours_wrong());
  EXPECT_FALSE(PlayedStudy({{kRightAnswer, kWrongAnswer}, {kGaveUp, kWrongAnswer}}).validate().ours_wrong());
  ASSERT_EQ(validation.over_sets.size(), 2U);
  EXPECT_EQ(validation.over_sets[0]["compared"], 11);
  ASSERT_EQ(validation.totals.size(), 1U);
  EXPECT_EQ(validation.totals[0]["reference"], "2 references");
  EXPECT_EQ(validation.totals[0]["compared"], 11 + 12);
}

/// w = -1 whatever z is; y = 1 proves it.
Problem without_solution(const std::string& name) { return {name, Lcp{Matrix::Zero(1, 1), Vector::Constant(1, -1.0)}}; }

TEST(ValidateTest, UnsolvableIsRightWhereItIsProven) {
  Answer proven = kDenied;
  proven.farkas = Vector::Ones(1);
  const Validation validation =
      PlayedStudy({{kDenied, proven}, {kGaveUp, proven}, {kWrongAnswer, proven}}, without_solution).validate();
  for (const char* reference : {"siconos_lemke", "truth"}) {
    const json pair = pair_with(validation, reference);
    EXPECT_EQ(pair["agree"], 1) << pair;
    EXPECT_EQ(pair["undecided"], 1) << pair;
    EXPECT_EQ(pair["native_wrong"], 1) << pair;
  }
}

/// The body of falling_body with friction. What is proven of the pyramid says nothing about the cone.
Problem rubbing_body(const std::string& name) {
  ContactProblem contact;
  contact.v = Vector::Unit(3, 0) * -1.0;
  contact.N = Matrix(Matrix::Identity(3, 1));
  contact.D = Matrix{{0, 0, 0, 0}, {1, 0, -1, 0}, {0, 1, 0, -1}};
  contact.edges = {4};
  contact.mu = Vector::Constant(1, 0.5);
  contact.inertia = DenseInertia{Matrix::Identity(3, 3)};
  return {name, contact};
}

TEST(ValidateTest, AnswersByDifferentModelsOfFrictionDoNotAgree) {
  Answer right = kRightAnswer, wrong = kWrongAnswer;
  right.z = Vector::Unit(6, 0);
  wrong.z = Vector::Zero(6);
  for (const FrictionModel model : {FrictionModel::kPyramid, FrictionModel::kCone, FrictionModel::kConvex}) {
    PlayedStudy played({{right, right}, {wrong, right}}, rubbing_body);
    played.set_model(model);
    const Validation validation = played.validate();
    for (const char* reference : {"siconos_lemke", "truth"}) {
      const json pair = pair_with(validation, reference);
      EXPECT_EQ(pair["agree"], model == FrictionModel::kPyramid ? 1 : 0) << pair;
      EXPECT_EQ(pair["undecided"], model == FrictionModel::kPyramid ? 0 : 1) << pair;
      EXPECT_EQ(pair["native_wrong"], 1) << "an answer that fails by its own model is false: " << pair;
    }
  }
}

TEST(ValidateTest, TwoVelocitiesWhereThereIsOneAreUndecidedAndReported) {
  const Validation validation = PlayedStudy({{kRightAnswer, kRightAnswer}, {kRightAnswer, kOtherVelocity}}).validate();
  const json pair = pair_with(validation, "siconos_lemke");
  EXPECT_EQ(pair["agree"], 1);
  EXPECT_EQ(pair["undecided"], 1);
  ASSERT_EQ(validation.disagreements.size(), 1U);
  EXPECT_EQ(validation.disagreements[0]["trial"], 1);
  EXPECT_EQ(validation.disagreements[0]["outcome"], "undecided");
}

// ---- real solvers ----

/// Lemke, untested, with tolerances that badly conditioned problems do not bear. Mostly it gives up; on 3 of the first
/// 1,000 problems of the set it claims an answer that is none, on trial 577 for one.
constexpr const char* kBadSetting = "lemke{pivot_tolerance=1e-4,zero_tolerance=1e-4}";
constexpr const char* kHardSet = "paper/copositive/exp5-1e10";
constexpr std::int64_t kFalselyClaimed = 577;

std::vector<std::string> names(const Plan& plan) {
  std::vector<std::string> names;
  for (const PlannedSolver& solver : plan.solvers) {
    if (names.empty() || names.back() != solver.spec.text()) names.push_back(solver.spec.text());
  }
  return names;
}

TEST(ValidationPlanTest, AsksForBothSides) {
  const std::vector<std::string> all = names(validation_plan({}, {}, 1000));
  EXPECT_EQ(std::count(all.begin(), all.end(), "lemke"), 1);
  EXPECT_EQ(std::count(all.begin(), all.end(), "external"), 0);  // has to be told its command
  for (const std::string& name : all) EXPECT_TRUE(runs_unasked(find_solver(name))) << name;

  const std::vector<std::string> one = names(validation_plan({parse_spec("lemke{engine=dense}")}, {}, 1000));
  EXPECT_EQ(one.front(), "lemke{engine=dense}");
  for (std::size_t i = 1; i < one.size(); ++i) EXPECT_FALSE(is_ours(find_solver(one[i]))) << one[i];

  const std::vector<std::string> both =
      names(validation_plan({parse_spec("lemke"), parse_spec("external{command=./mine}")}, {}, 1000));
  EXPECT_EQ(both, (std::vector<std::string>{"lemke", "external{command=./mine}"}));
}

std::int64_t problems_of(const Study& study, const std::string& solver, std::size_t set = 0) {
  for (const StudySolver& planned : study.solvers) {
    if (planned.row.name != solver) continue;
    std::int64_t taken = 0;
    for (std::int64_t trial = 0; trial < study.sets[set].trials; ++trial) taken += planned.takes(set, trial) ? 1 : 0;
    return taken;
  }
  return -1;
}

TEST(ValidationPlanTest, SlowReferencesLeaveOutProblemsUnlessTheyAreAskedFor) {
  const std::vector<std::string> set{"paper/copositive/exp1"};
  const std::string slow = "siconos_lemke";
  if (!runs_unasked(find_solver(slow))) GTEST_SKIP() << slow << " is not available here";
  EXPECT_EQ(problems_of(validation_study(validation_plan({}, set, 1000)), slow), 200);
  EXPECT_EQ(problems_of(validation_study(validation_plan({}, set, 1000)), "lemke"), 1000);
  EXPECT_EQ(problems_of(validation_study(validation_plan({}, set, 20)), slow), 20);
  EXPECT_EQ(problems_of(validation_study(validation_plan({parse_spec(slow)}, set, 1000)), slow), 1000);
  const Study small = validation_study(validation_plan({}, {"scene/box/ode"}, 1000));
  EXPECT_EQ(problems_of(small, slow), small.sets[0].trials) << "all of a set that has fewer than 20";
}

// ---- the command ----

class ValidateCommandTest : public ProgramTest {};

/// A reference that answers fast, where there is one.
constexpr const char* kReference = "siconos_lemke";

TEST_F(ValidateCommandTest, PrintsTheFieldsOfTheInterface) {
  if (!runs_unasked(find_solver(kReference))) GTEST_SKIP() << kReference << " is not available here";
  const json document = run_json(
      "validate --solver lemke --solver siconos_lemke --set paper/monotone/exp1 --set paper/monotone/exp2 --trials 20");
  ASSERT_EQ(document.size(), 3U);
  EXPECT_TRUE(document.at("provenance").is_object());
  EXPECT_EQ(document.at("ok"), true);
  ASSERT_EQ(document.at("pairs").size(), 4U);  // two sets, each with the library and with the truth
  for (const json& pair : document.at("pairs")) {
    ASSERT_EQ(pair.size(), 9U) << pair.dump();
    EXPECT_EQ(pair.at("compared"), 20);
    EXPECT_EQ(pair.at("native"), "lemke");
  }
  EXPECT_EQ(document.at("pairs")[0].at("set"), "paper/monotone/exp1");
  EXPECT_EQ(document.at("pairs")[0].at("reference"), kReference);
}

TEST_F(ValidateCommandTest, ABadSettingExitsWith1AndSavesWhatItGotWrong) {
  if (!runs_unasked(find_solver(kReference))) GTEST_SKIP() << kReference << " is not available here";
  const std::string bad = std::string("--solver '") + kBadSetting + "'";
  done("generate " + std::string(kHardSet) + " --seed 1 --count 1 --first " + std::to_string(kFalselyClaimed) +
       " --out hard");
  std::filesystem::copy(folder_ / "hard", folder_ / "ha rd");
  const ProgramRun output =
      run("validate " + bad + " --solver siconos_lemke --set file:hard --set 'file:ha rd' --out disagreements");
  EXPECT_EQ(output.exit_code, 1) << output.err;
  EXPECT_TRUE(contains(output.out, "OURS IS WRONG")) << output.out;
  const std::vector<std::string> index = lines_of(read("disagreements/disagreements.csv"));
  ASSERT_EQ(index.size(), 5U) << "of each set with the library and with the truth";
  std::set<std::string> files;
  for (std::size_t i = 1; i < index.size(); ++i) {
    EXPECT_TRUE(contains(index[i], "native_wrong")) << index[i];
    files.insert(index[i].substr(0, index[i].find(',')));
  }
  EXPECT_EQ(files.size(), 2U) << "sets whose names are alike have a problem each";
  for (const std::string& file : files) {
    EXPECT_EQ(run_json("solve disagreements/" + file + " " + bad).at(0).at("verdict"), "wrong") << file;
  }
}

TEST_F(ValidateCommandTest, LeavesNothingBehindWhenAllAgree) {
  if (!runs_unasked(find_solver(kReference))) GTEST_SKIP() << kReference << " is not available here";
  done("validate --solver lemke --solver siconos_lemke --set planted/definite --trials 20");
  const auto files = std::filesystem::directory_iterator(folder_ / "");
  EXPECT_EQ(std::distance(begin(files), end(files)), 2) << "out and err";
}

TEST_F(ValidateCommandTest, WhatWasDoneIsKeptInAStoreThatWasAskedFor) {
  expect_mistake(
      "validate --store s.db --set planted/definite --trials 1 --solver lemke --solver 'external{command=false}'");
  EXPECT_TRUE(contains(read("err"), "kept in s.db")) << read("err");
}

}  // namespace
}  // namespace lcpbench::validate_test
