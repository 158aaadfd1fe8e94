// A study that ended before its plan was done must look like one: in the report, on the terminal, in summary.json.

#include "study/report/text.h"

#include <cmath>

#include <gtest/gtest.h>

#include "study/report/report.h"
#include "study/run/runner.h"
#include "study/store/merge.h"
#include "tests/support/program_run.h"
#include "tests/support/synthetic_store.h"

namespace lcpbench::coverage_test {
namespace {

Study small_study(std::int64_t trials = 8) {
  Plan plan;
  plan.name = "small";
  plan.trials = trials;
  plan.repeat_until_s = 0;
  plan.sets = {{.pattern = "paper/monotone/exp1"},
               {.pattern = "paper/monotone/exp3"},
               {.pattern = "paper/copositive/exp1{nc_max=3}", .trials = 4}};
  plan.solvers.push_back({.spec = parse_spec("lemke")});
  plan.solvers.push_back({.spec = parse_spec("murty"), .every = 3});
  plan.solvers.push_back({.spec = parse_spec("lemke"), .sweep = builtin_sweep("paper", parse_spec("lemke"))});
  return resolve(plan);
}
/// Lemke alone and its 81 cells on every trial, murty on each third.
constexpr std::int64_t kSmallCells = 2 * (8 * 82 + 3) + 4 * 82 + 2;

/// Runs a study as `lcpbench run` does: what it plans is recorded first.
void run(const Study& study, const std::filesystem::path& file, const RunOptions& options = {},
         const char* started = "1", const nlohmann::ordered_json& planned = nullptr) {
  Store store = Store::open_for_writing(file);
  store.begin();
  store.add_run(started, nlohmann::ordered_json{{"planned", planned.is_null() ? planned_cells(study) : planned},
                                                {"shard", options.shard}}
                             .dump());
  store.commit();
  run_study(study, store, options);
}

/// Leaves what a run leaves that was stopped, whatever this machine's speed: a plan, and the work of a smaller one.
void run_part(const Study& planned, const Study& done, const std::filesystem::path& file) {
  run(done, file, {}, "1", planned_cells(planned));
}

Coverage coverage(const std::filesystem::path& file) {
  Store store = Store::open_for_reading(file);
  return summarize(store).coverage;
}

TEST(CoverageTest, AWholeRunHasNothingToTell) {
  const ScratchFolder folder;
  run(small_study(), folder / "s.db");
  const Coverage whole = coverage(folder / "s.db");
  EXPECT_TRUE(whole.known);
  EXPECT_FALSE(whole.incomplete());
  EXPECT_EQ(whole.planned, kSmallCells);
  EXPECT_EQ(whole.done, kSmallCells);
  EXPECT_EQ(planned_cells(small_study())["cells"], kSmallCells);
  EXPECT_EQ(report::coverage_text(whole), "");
}

TEST(CoverageTest, ATruncatedRunKnowsWhatIsMissingUntilItIsResumed) {
  const ScratchFolder folder;
  run_part(small_study(), small_study(3), folder / "s.db");
  const Coverage part = coverage(folder / "s.db");
  EXPECT_TRUE(part.incomplete());
  EXPECT_EQ(part.planned, kSmallCells);
  EXPECT_GT(part.done, 0);
  EXPECT_LT(part.done, kSmallCells);
  run(small_study(), folder / "s.db", {}, "2");
  EXPECT_EQ(coverage(folder / "s.db").done, kSmallCells);
  EXPECT_FALSE(coverage(folder / "s.db").incomplete());
}

TEST(CoverageTest, MoreTrialsAreMorePlanAndARepetitionIsNot) {
  const ScratchFolder folder;
  run(small_study(8), folder / "s.db");
  run(small_study(8), folder / "s.db", {}, "2");
  EXPECT_EQ(coverage(folder / "s.db").planned, kSmallCells);
  run_part(small_study(80), small_study(8), folder / "s.db");
  EXPECT_GT(coverage(folder / "s.db").planned, 9 * kSmallCells / 2);
  EXPECT_TRUE(coverage(folder / "s.db").incomplete());
}

/// Runs of other lengths and subsamples: a trial that several plan is planned once.
TEST(CoverageTest, OverlappingPlansCountEachTrialOnce) {
  const ScratchFolder folder;
  Store store = Store::open_for_writing(folder / "s.db");
  for (const auto& [trials, every] : std::vector<std::pair<std::int64_t, std::int64_t>>{{10, 1}, {100, 2}, {1000, 3}}) {
    Plan plan;
    plan.name = "part";
    plan.trials = trials;
    plan.sets = {{.pattern = "paper/monotone/exp1"}};
    plan.solvers = {{.spec = parse_spec("lemke"), .every = every}};
    store.begin();
    store.add_run(std::to_string(trials), nlohmann::ordered_json{{"planned", planned_cells(resolve(plan))}}.dump());
    store.commit();
  }
  // 0..9; of 10..99 the 45 even ones and the 15 odd ones that 3 divides; of 100..999 the 300 that 3 divides.
  EXPECT_EQ(summarize(store).coverage.planned, 10 + 60 + 300);
}

TEST(CoverageTest, AShardIsPartOfThePlanAndAllOfThemAreTheWhole) {
  const ScratchFolder folder;
  run(small_study(), folder / "1.db", {.shard = 0, .shards = 2});
  run(small_study(), folder / "2.db", {.shard = 1, .shards = 2});
  EXPECT_TRUE(coverage(folder / "1.db").incomplete());
  EXPECT_EQ(coverage(folder / "1.db").planned, kSmallCells);
  merge_stores(folder / "one.db", {folder / "1.db"});
  EXPECT_TRUE(coverage(folder / "one.db").incomplete());
  merge_stores(folder / "both.db", {folder / "1.db", folder / "2.db"});
  EXPECT_EQ(coverage(folder / "both.db").done, kSmallCells);
  EXPECT_FALSE(coverage(folder / "both.db").incomplete());
}

/// One machine of two lacks the library of a solver: its cells are missing, and said to be.
TEST(CoverageTest, ASolverThatOneRunLeftOutIsNamedWithItsMissingCells) {
  const ScratchFolder folder;
  Study lacking = small_study();
  lacking.left_out = {lacking.solvers[1]};
  lacking.solvers.erase(lacking.solvers.begin() + 1);
  lacking.skipped = {"murty: its library was not found"};
  run(small_study(), folder / "1.db", {.shard = 0, .shards = 2});
  {
    Store store = Store::open_for_writing(folder / "2.db");
    store.begin();
    store.add_run("2",
                  nlohmann::ordered_json{
                      {"planned", planned_cells(lacking)}, {"shard", 1}, {"skipped", lacking.skipped}}
                      .dump());
    store.commit();
    run_study(lacking, store, {.shard = 1, .shards = 2});
  }
  merge_stores(folder / "both.db", {folder / "1.db", folder / "2.db"});
  const Coverage both = coverage(folder / "both.db");
  EXPECT_EQ(both.planned, kSmallCells);
  ASSERT_EQ(both.left_out.size(), 1U);
  const std::int64_t missing = both.left_out.at("murty: its library was not found");
  EXPECT_EQ(both.planned - both.done, missing);
  EXPECT_GT(missing, 0);
  const std::string line = std::to_string(missing) +
                           " planned cells are missing, and not failures, since a run left out murty: its "
                           "library was not found\n";
  EXPECT_NE(report::coverage_text(both).find(line), std::string::npos) << report::coverage_text(both);
  run(small_study(), folder / "2.db", {.shard = 1, .shards = 2}, "3");
  EXPECT_TRUE(coverage(folder / "2.db").incomplete());
  EXPECT_TRUE(coverage(folder / "2.db").left_out.empty()) << "what it lacks is in the other shard";
  merge_stores(folder / "both.db", {folder / "2.db"});
  EXPECT_FALSE(coverage(folder / "both.db").incomplete());
  EXPECT_TRUE(coverage(folder / "both.db").left_out.empty());
}

/// What `planned_cells` records: one solver on every problem of two sets, 200 and 100.
constexpr const char* kPlan =
    R"({"cells": 300, "seed": 1, "sets": [{"set": "paper/monotone/exp1", "trials": 200},)"
    R"( {"set": "paper/monotone/exp2", "trials": 100}], "solvers": [{"solver": "lemke", "sweep": "", "cells": 1,)"
    R"( "on": [{"every": [1], "sets": [0, 1]}]}]})";

class TruncatedStoreTest : public ::testing::Test {
 protected:
  void fill(std::int64_t first_set, std::int64_t second_set, const std::string& plan = kPlan) {
    SyntheticStore made(folder_ / "s.db", plan);
    const auto solver = made.solver("lemke");
    for (std::int64_t trial = 0; trial < first_set; ++trial) made.problem("paper/monotone/exp1", trial, {{solver, {}}});
    for (std::int64_t trial = 0; trial < second_set; ++trial)
      made.problem("paper/monotone/exp2", trial, {{solver, {}}});
    coverage_ = summarize(made.store()).coverage;
    write_report(made.store(), folder_ / "out");
    report_ = nlohmann::json::parse(read_file(folder_ / "out/report.json"));
    document_ = nlohmann::json::parse(read_file(folder_ / "out/summary.json"));
  }

  ScratchFolder folder_;
  Coverage coverage_;
  nlohmann::json report_;
  nlohmann::json document_;
};

TEST_F(TruncatedStoreTest, IsSaidToBeTruncatedAtTheTopAndInTheSummary) {
  fill(22, 11);
  EXPECT_EQ(report_["plan"]["cells_planned"], 300);
  EXPECT_EQ(report_["plan"]["cells_done"], 33);
  EXPECT_EQ(report_["sets"][1]["planned"], 100);
  EXPECT_EQ(report_["sets"][1]["done"], 11);
  const auto& coverage = document_["coverage"];
  EXPECT_EQ(coverage["planned"], 300);
  EXPECT_EQ(coverage["done"], 33);
  EXPECT_DOUBLE_EQ(coverage["share"], 0.11);
  EXPECT_EQ(coverage["sets"][1]["set"], "paper/monotone/exp2");
  EXPECT_EQ(coverage["sets"][1]["done"], 11);
  EXPECT_EQ(coverage["sets"][1]["thin"], true);
  EXPECT_EQ(report::coverage_text(coverage_),
            "INCOMPLETE: 11 % of the plan (33 of 300 cells); 2 of 2 sets are thin:\n"
            "   11 %  paper/monotone/exp1\n   11 %  paper/monotone/exp2\n"
            "To complete it, repeat the lcpbench run that wrote it; where it was run in shards, merge their stores.\n");
}

/// Enough problems for the interval, not for what the plan was to tell.
TEST_F(TruncatedStoreTest, TheTableWithholdsWhatAThinPlanCannotCarry) {
  fill(60, 30);
  const std::string withheld = report_["situations"][0]["withheld"];
  EXPECT_TRUE(withheld.starts_with(
      "too few to say: 90 problems, 30 % of the plan; the report needs 50 % of it, or 381 problems")) << withheld;
  EXPECT_EQ(document_["decision"][0]["recommended"], false);
  EXPECT_TRUE(document_["decision"][0]["reliable"].is_null());
  EXPECT_EQ(document_["decision"][0]["reliability"], "short_of_plan");
}

TEST_F(TruncatedStoreTest, ASetThatWasNotBegunIsNamedToo) {
  fill(200, 0);
  const std::string text = report::coverage_text(coverage_);
  EXPECT_NE(text.find("66 % of the plan"), std::string::npos) << text;
  EXPECT_NE(text.find("1 of 2 sets are thin:\n    0 %  paper/monotone/exp2\n"), std::string::npos) << text;
}

TEST_F(TruncatedStoreTest, AlmostWholeIsNotWholeAndNoSetIsThin) {
  fill(200, 99);
  const std::string text = report::coverage_text(coverage_);
  EXPECT_NE(text.find("99 % of the plan"), std::string::npos) << text;
  EXPECT_EQ(text.find("thin"), std::string::npos) << text;
}

TEST_F(TruncatedStoreTest, AWholeStoreSaysNothing) {
  fill(200, 100);
  EXPECT_EQ(report::coverage_text(coverage_), "");
  EXPECT_EQ(report_["plan"]["share"], 1);
  EXPECT_EQ(document_["coverage"]["share"], 1);
  EXPECT_EQ(document_["coverage"]["sets"][0]["thin"], false);
}

TEST_F(TruncatedStoreTest, AStoreWithoutAPlanSaysThatNobodyKnows) {
  for (const char* plan : {"", "{}", "7", R"({"seed": 1, "sets": [], "solvers": [{"on": 3}]})"}) {
    std::filesystem::remove(folder_ / "s.db");
    fill(5, 0, plan);
    EXPECT_FALSE(coverage_.known) << plan;
    EXPECT_TRUE(coverage_.left_out.empty()) << plan;
    EXPECT_TRUE(report_["plan"]["share"].is_null()) << plan;
    EXPECT_TRUE(report_["sets"][0]["planned"].is_null()) << plan;
    EXPECT_TRUE(document_["coverage"]["share"].is_null()) << plan;
  }
}

/// The same solver at two instruction-set levels, on different machines: the plan asks for one of them.
TEST_F(TruncatedStoreTest, ALevelOrVersionIsNoWorkOfItsOwn) {
  SyntheticStore made(folder_ / "levels.db", kPlan);
  const auto baseline = made.solver("lemke");
  made.store().begin();
  const auto other = made.store().add_solver({"lemke", "", "engine=dense", "native", "1.0", "avx2", ""});
  made.store().commit();
  for (std::int64_t trial = 0; trial < 100; ++trial) {
    made.problem("paper/monotone/exp2", trial, {{trial % 2 == 0 ? baseline : other, {}}});
  }
  made.problem("paper/monotone/exp1", 0, {{baseline, {}}, {other, {}}});
  const Coverage coverage = summarize(made.store()).coverage;
  EXPECT_EQ(coverage.sets[1].done, 100);
  EXPECT_EQ(coverage.sets[0].done, 1);
}

/// The engines' answers are asked for where a glob, too, names captured steps.
TEST(EverySolverTest, AGlobThatNamesCapturedStepsHasTheEngine) {
  const ScratchFolder folder;
  const auto engines = [&](const std::string& pattern) {
    const ProgramRun run =
        run_program(folder / "", "run --set '" + pattern + "' --trials 1 --fresh --store s.db --jobs 1");
    EXPECT_EQ(run.exit_code, 0) << run.err;
    sqlite::Database store(folder / "s.db", sqlite::Mode::kReadOnly);
    return store.integer("SELECT COUNT(*) FROM solvers WHERE name = 'engine'");
  };
  EXPECT_EQ(engines("*/wedge/ode"), 1);
  EXPECT_EQ(engines("paper/monotone/exp1"), 0);
}

/// The program itself: what a budget cut off is said in the last lines of `run` and `report`, with exit code 0.
TEST(TruncatedRunTest, NobodyCanMissItOnTheTerminal) {
  const ScratchFolder folder;
  const std::string study = "--set paper/monotone/exp1 --set paper/monotone/exp2 --solver lemke --store s.db ";
  const ProgramRun cut = run_program(folder / "", "run " + study + "--trials 100000000 --budget 2");
  EXPECT_EQ(cut.exit_code, 0) << cut.err;
  const std::size_t notice = cut.out.find("INCOMPLETE: ");
  ASSERT_NE(notice, std::string::npos) << cut.out;
  EXPECT_EQ(cut.out.find("%  paper/monotone/exp3", notice), std::string::npos);
  EXPECT_NE(cut.out.find("%  paper/monotone/exp1", notice), std::string::npos);
  EXPECT_NE(cut.out.find(" of 200,000,000 cells in "), std::string::npos) << cut.out;
  EXPECT_NE(cut.out.find("time budget of 2 s is used up", notice), std::string::npos);
  const ProgramRun report = run_program(folder / "", "report s.db --out made");
  EXPECT_EQ(report.exit_code, 0);
  EXPECT_EQ(report.out, "made/report.html\n");
  EXPECT_NE(report.err.find("INCOMPLETE: "), std::string::npos) << report.err;

  const ProgramRun whole = run_program(folder / "", "run " + study + "--trials 5 --fresh");
  EXPECT_EQ(whole.exit_code, 0);
  EXPECT_EQ(whole.out.find("INCOMPLETE"), std::string::npos) << whole.out;
  EXPECT_EQ(run_program(folder / "", "report s.db --out whole").err, "");
}

}  // namespace
}  // namespace lcpbench::coverage_test
