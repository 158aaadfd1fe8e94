// What a user relies on: a plan does what it says, or one line says what is wrong with it and where.

#include "study/run/plan.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/registry.h"
#include "generators/scenes/scenes.h"
#include "study/run/study.h"
#include "tests/support/study_support.h"

namespace lcpbench::plan_test {
namespace {

std::string plan_text(const std::string& fields) {
  return R"({"format": "lcpbench-plan", "version": 1, "name": "mine", )" + fields + "}";
}

const std::string kSets = R"("sets": ["paper/monotone/exp1"])";
const std::string kSolvers = R"("solvers": ["lemke"])";

struct Bad {
  std::string text;
  std::string complaint;  ///< the whole line, without the file's name
};

void PrintTo(const Bad& bad, std::ostream* out) { *out << bad.complaint; }

class BadPlanTest : public ::testing::TestWithParam<Bad> {};

TEST_P(BadPlanTest, IsRefusedInOneLineThatNamesThePlace) {
  try {
    parse_plan(GetParam().text, "p.json");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    const std::string line = error.what();
    EXPECT_EQ(line.rfind("p.json: " + GetParam().complaint, 0), 0U) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Plans, BadPlanTest,
    ::testing::Values(
        Bad{"", "empty file"}, Bad{"[]", "expected an object, found a list"},
        Bad{"{\n", "truncated: the file ends at line 2, column 1"}, Bad{"{}", "format: missing"},
        Bad{R"({"format": "x"})", "format: expected 'lcpbench-plan'"},
        Bad{R"({"format": "lcpbench-plan", "version": 2, "name": "a", "sets": [], "solvers": []})",
            "version is 2, expected an integer in [1, 1]"},
        Bad{plan_text(kSets), "solvers: missing"}, Bad{plan_text(kSolvers), "sets: missing"},
        Bad{plan_text(R"("sets": [], )" + kSolvers), "sets: a plan needs a set"},
        Bad{plan_text(kSets + R"(, "solvers": [])"), "solvers: a plan needs a solver"},
        Bad{plan_text(kSets + ", " + kSolvers + R"(, "trails": 5)"), "unknown field 'trails'"},
        Bad{plan_text(kSets + ", " + kSolvers + R"(, "trials": 5, "trials": 6)"), "trials: given twice"},
        Bad{plan_text(kSets + ", " + kSolvers + R"(, "trials": 0)"),
            "trials is 0, expected an integer in [1, 100000000]"},
        Bad{plan_text(kSets + ", " + kSolvers + R"(, "trials": 1.5)"), "trials is 1.5, expected an integer"},
        Bad{plan_text(kSets + ", " + kSolvers + R"(, "trials": "5")"), "trials: expected a number, found a text"},
        Bad{plan_text(kSets + ", " + kSolvers + R"(, "trials": 99999999999999999999)"),
            "trials is 1e+20, expected an integer"},
        Bad{plan_text(kSets + ", " + kSolvers + R"(, "seed": -1)"), "seed is -1, expected an integer in [0, 2^64)"},
        Bad{plan_text(kSets + ", " + kSolvers + R"(, "time_limit_s": 0)"),
            "time_limit_s is 0, expected a number in (0, "},
        Bad{plan_text(kSets + ", " + kSolvers + R"(, "time_limit_s": null)"),
            "time_limit_s: expected a number, found null"},
        Bad{plan_text(kSets + ", " + kSolvers + R"(, "jobs": 0)"), "jobs is 0, expected an integer in [1, 1024]"},
        Bad{plan_text(kSets + R"(, "solvers": ["nope"])"), "solvers[0].solver: unknown solver 'nope'"},
        Bad{plan_text(kSets + R"(, "solvers": ["lemke", "lemke{"])"), "solvers[1].solver: "},
        Bad{plan_text(kSets + R"(, "solvers": ["lemke{foo=1}"])"), "solvers[0].solver: lemke: unknown option 'foo'"},
        Bad{plan_text(kSets + R"(, "solvers": [7])"), "solvers[0]: expected an object, found a number"},
        Bad{plan_text(kSets + R"(, "solvers": [{"every": 2}])"), "solvers[0].solver: missing"},
        Bad{plan_text(kSets + R"(, "solvers": [{"solver": "lemke", "every": 0}])"),
            "solvers[0].every is 0, expected an integer"},
        Bad{plan_text(kSets + R"(, "solvers": [{"solver": "lemke", "sweep": "pap"}])"),
            "solvers[0].sweep: unknown sweep 'pap'"},
        Bad{plan_text(kSets + R"(, "solvers": [{"solver": "murty", "sweep": "paper"}])"),
            "solvers[0].sweep: sweep 'paper': the paper has no grid for solver 'murty'"},
        Bad{plan_text(kSets + R"(, "solvers": [{"solver": "lemke", "sweep": {"name": "s", "grid": {"foo": [1]}}}])"),
            "solvers[0].sweep: lemke: unknown option 'foo'"},
        Bad{plan_text(kSets +
                      R"(, "solvers": [{"solver": "lemke", "sweep": {"name": "s", "grid": {"pivot_tolerance": []}}}])"),
            "solvers[0].sweep.grid.pivot_tolerance: expected a list of values"},
        Bad{plan_text(kSets + R"(, "solvers": [{"solver": "lemke", "sets": []}])"),
            "solvers[0].sets: a solver needs a set"},
        Bad{plan_text(kSets + R"(, "solvers": [{"solver": "lemke", "sets": "a"}])"),
            "solvers[0].sets: expected a list of texts, found a text"},
        Bad{plan_text(kSets + R"(, "solvers": [{"solver": "lemke", "sets": ["a", 1]}])"),
            "solvers[0].sets[1]: expected a text, found a number"},
        Bad{plan_text(R"("sets": [{"set": "a", "share": 0}], )" + kSolvers),
            "sets[0].share is 0, expected a number in (0, 1]"},
        Bad{plan_text(R"("sets": [{"set": "a", "share": 1.01}], )" + kSolvers),
            "sets[0].share is 1.01, expected a number in (0, 1]"},
        Bad{plan_text(R"("sets": [{"set": "a", "share": "all"}], )" + kSolvers), "sets[0].share: expected a number"},
        Bad{plan_text(R"("sets": [{"set": "a", "share": 0.5, "trials": 5}], )" + kSolvers),
            "sets[0].trials and 'share' exclude each other"},
        Bad{plan_text(R"("sets": [{"set": "a", "trials": -3}], )" + kSolvers),
            "sets[0].trials is -3, expected an integer"},
        Bad{R"({"format": "lcpbench-plan", "version": 1, "name": "../x", )" + kSets + "," + kSolvers + "}",
            "name: expected a name of letters"},
        Bad{std::string(100000, '['), "more than 10 levels of lists and objects"}));

TEST(PlanTest, ReadsEveryField) {
  const Plan plan =
      parse_plan(plan_text(R"("description": "d", "seed": 18446744073709551615, "trials": 7, "time_limit_s": 0.5,
                   "repeat_until_s": 0, "budget_s": 60, "jobs": 3, "sets": ["a", {"set": "b", "trials": 2},
                   {"set": "c", "share": 0.25}],
                   "solvers": ["lemke", {"solver": "primal_dual{eps=1e-9}", "every": 4, "optional": true,
                                         "sets": ["a", "c*"]}])"),
                 "p.json");
  EXPECT_EQ(plan.name, "mine");
  EXPECT_EQ(plan.seed, 18446744073709551615U);
  EXPECT_EQ(plan.trials, 7);
  EXPECT_EQ(plan.time_limit_s, 0.5);
  EXPECT_EQ(plan.repeat_until_s, 0.0);
  EXPECT_EQ(plan.budget_s, 60.0);
  EXPECT_EQ(plan.jobs, 3);
  EXPECT_FALSE(plan.sets.at(0).trials.has_value());
  EXPECT_EQ(plan.sets.at(1).trials, 2);
  EXPECT_FALSE(plan.sets.at(1).share.has_value());
  EXPECT_EQ(plan.sets.at(2).share, 0.25);
  EXPECT_EQ(plan.solvers.at(1).sets, (std::vector<std::string>{"a", "c*"}));
  EXPECT_TRUE(plan.solvers.at(0).sets.empty());
  EXPECT_EQ(plan.solvers.at(1).spec.text(), "primal_dual{eps=1e-09}");
  EXPECT_EQ(plan.solvers.at(1).every, 4);
  EXPECT_TRUE(plan.solvers.at(1).optional);
  EXPECT_FALSE(plan.solvers.at(0).optional);
}

TEST(PlanTest, JsonReadsBackToThePlan) {
  const Plan plan =
      parse_plan(plan_text(R"("sets": [{"set": "a", "share": 0.1}, {"set": "b", "trials": 3}], "budget_s": 3,
                             "solvers": [{"solver": "lemke", "sweep": "paper", "every": 2, "sets": ["a", "b?"]},
                             {"solver": "lemke", "sweep": {"name": "s", "grid": {"pivot_tolerance": [1e-12, "1e-8"]}}}])"),
                 "p.json");
  const std::string written = plan_json(plan);
  EXPECT_EQ(plan_json(parse_plan(written, "written")), written);
}

TEST(PlanTest, BuiltInPlansArePlansInTheFormOfAFile) {
  for (const auto& [name, text] : kBuiltinPlans) {
    const Plan plan = load_plan(std::string(name));
    EXPECT_EQ(plan.name, name);
    const Study study = resolve(plan);
    EXPECT_GE(study.sets.size(), 3U);
    EXPECT_GE(study.solvers.size() + study.skipped.size(), 9U);
    const ScratchFolder folder;
    const std::string file = (folder / "copy.json").string();
    std::ofstream(file) << text;
    EXPECT_EQ(plan_json(load_plan(file)), plan_json(plan));
  }
}

std::vector<std::string> scenes_of(const Study& study) {
  std::vector<std::string> names;
  for (const StudySet& set : study.sets) {
    if (set.set->name().starts_with("scene/")) names.push_back(set.set->name());
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// A scene that is added to the collection is in both plans, and in `quick` for a few steps.
TEST(PlanTest, TheCollectedScenesAreAllInTheStudyOfScenesAndAShareInTheQuickOne) {
  std::vector<std::string> all;
  for (const CollectedScene& scene : collected_scenes()) all.push_back(scene.name);
  std::sort(all.begin(), all.end());
  const Study scenes = resolve(load_plan("scenes"));
  EXPECT_EQ(scenes_of(scenes), all);
  EXPECT_EQ(scenes.sets.size(), all.size());
  for (const StudySet& set : scenes.sets) EXPECT_EQ(set.trials, set.set->count()) << set.set->name();

  const Study quick = resolve(load_plan("quick"));
  EXPECT_EQ(scenes_of(quick), all);
  std::int64_t steps = 0;
  for (const StudySet& set : quick.sets) {
    if (!set.set->name().starts_with("scene/")) continue;
    EXPECT_LE(set.trials, 5) << set.set->name();
    steps += set.trials;
  }
  EXPECT_LE(steps, 250);
}

TEST(PlanTest, WhatIsNoPlanFileIsCalledWhatItIs) {
  const auto complaint = [](const std::filesystem::path& file) -> std::string {
    try {
      load_plan(file.string());
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  };
  const ScratchFolder folder;
  std::ofstream(folder / "empty.json").close();
  EXPECT_NE(complaint("no-such-plan.json").find("neither a file nor built in"), std::string::npos);
  EXPECT_NE(complaint(folder / "empty.json").find("empty.json: empty file"), std::string::npos);
  EXPECT_NE(complaint(folder / "").find("is a folder, expected a plan file"), std::string::npos);
}

TEST(SweepTest, PaperGridsHaveThePapersCells) {
  const auto cells = [](const char* solver) {
    const Spec spec = parse_spec(solver);
    return sweep_cells(builtin_sweep("paper", spec), spec);
  };
  EXPECT_EQ(cells("lemke").size(), 81U);
  EXPECT_EQ(cells("lemke").front().text(), "lemke{pivot_tolerance=1e-20,zero_tolerance=1e-20,test=none}");
  EXPECT_EQ(cells("lemke").back().text(), "lemke{pivot_tolerance=1e-04,zero_tolerance=1e-04,test=none}");
  EXPECT_EQ(cells("primal_dual").size(), 9U);
  EXPECT_EQ(cells("regularized{solver=lemke{engine=dense}}").size(), 81U);
  EXPECT_EQ(
      cells("regularized{solver=lemke{engine=dense}}").front().text(),
      "regularized{solver=lemke{engine=dense,pivot_tolerance=1e-20,zero_tolerance=1e-20,test=none},test=original}");
}

TEST(SweepTest, WrappingASolverWithoutAGridGivesNone) {
  for (const char* solver : {"murty", "regularized{solver=murty}", "regularized{solver=murty,test=tried}"}) {
    const Spec spec = parse_spec(solver);
    EXPECT_FALSE(has_builtin_sweep("paper", spec)) << solver;
    EXPECT_THROW(builtin_sweep("paper", spec), InputError) << solver;
  }
}

TEST(SweepTest, LabelTellsWhatWasSwept) {
  EXPECT_EQ(sweep_label("paper", parse_spec("lemke")), "paper");
  EXPECT_EQ(sweep_label("paper", parse_spec("lemke{engine=dense}")), "paper{engine=dense}");
}

TEST(ResolveTest, SameSetWithTwoNumbersOfTrialsIsRefused) {
  Plan plan;
  plan.name = "p";
  plan.sets = {{.pattern = "paper/monotone/*", .trials = 3}, {.pattern = "paper/monotone/exp1", .trials = 4}};
  plan.solvers = {PlannedSolver{.spec = {"lemke", {}}}};
  EXPECT_THROW(resolve(plan), InputError);
  plan.sets[1].trials = 3;
  EXPECT_EQ(resolve(plan).sets.size(),
            resolve(Plan{.name = "q", .sets = {{.pattern = "paper/monotone/*", .trials = 3}}, .solvers = plan.solvers})
                .sets.size());
}

std::string resolve_error(const Plan& plan) {
  try {
    resolve(plan);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError";
}

TEST(ResolveTest, ShareOfTheTrialsIsRoundedUp) {
  Plan plan{.name = "p", .sets = {{.pattern = "paper/monotone/exp1"}}, .solvers = {{.spec = {"lemke", {}}}}};
  const auto trials = [&](double share, std::int64_t of) {
    plan.sets[0].share = share;
    plan.trials = of;
    return resolve(plan).sets.at(0).trials;
  };
  EXPECT_EQ(trials(0.25, 2000), 500);
  EXPECT_EQ(trials(0.07, 100), 7);  // 0.07 * 100 is 7.000000000000001
  EXPECT_EQ(trials(0.071, 100), 8);
  EXPECT_EQ(trials(1e-9, 3), 1);
  EXPECT_EQ(trials(1, 3), 3);
}

TEST(ResolveTest, PatternOfASolverThatMatchesNoSetIsRefused) {
  Plan plan{.name = "p",
            .sets = {{.pattern = "paper/monotone/exp2{redundancy=combination}"}},
            .solvers = {{.spec = {"lemke", {}}, .sets = {"paper/monotone/exp2"}}}};
  EXPECT_EQ(resolve_error(plan), "plan p: solver 'lemke': sets: 'paper/monotone/exp2' matches none of the plan's sets");
  plan.other_sets = true;
  EXPECT_TRUE(resolve(plan).solvers.empty());
  for (const char* pattern : {"paper/monotone/exp2{*}", "*exp2*", "*combination}", "paper/*/exp?{redundancy=*", "*",
                              "paper/monotone/exp2{redundancy=combination}"}) {
    plan.solvers[0].sets = {pattern};
    EXPECT_EQ(resolve(plan).solvers.size(), 1U) << pattern;
  }
  for (const char* pattern :
       {"paper/monotone/exp?", "paper/*/exp", "", "*exp2{redundancy=combination}?", "monotone*"}) {
    plan.solvers[0].sets = {pattern};
    EXPECT_TRUE(resolve(plan).solvers.empty()) << pattern;
  }
}

TEST(ResolveTest, SolverGivenTwiceRunsWhereEitherEntryDoes) {
  Plan plan{.name = "p",
            .sets = {{.pattern = "paper/monotone/exp1"}, {.pattern = "paper/monotone/exp2"}},
            .solvers = {{.spec = {"lemke", {}}, .every = 2, .sets = {"*exp1"}},
                        {.spec = {"lemke", {}}, .every = 3, .sets = {"*exp?"}}}};
  const Study study = resolve(plan);
  ASSERT_EQ(study.solvers.size(), 1U);
  std::string taken;
  for (std::size_t set = 0; set < 2; ++set) {
    for (std::int64_t trial = 0; trial < 7; ++trial) taken += study.solvers[0].takes(set, trial) ? 'x' : '-';
    taken += ' ';
  }
  EXPECT_EQ(taken, "x-xxx-x x--x--x ");
}

TEST(ResolveTest, TwoGridsUnderOneNameAreRefused) {
  const auto sweep = [](const char* value) { return Sweep{"mine", {{"zero_tolerance", {"1e-8", value}}}}; };
  Plan plan{
      .name = "p",
      .sets = {{.pattern = "paper/monotone/exp1"}},
      .solvers = {{.spec = {"lemke", {}}, .sweep = sweep("1e-6")}, {.spec = {"lemke", {}}, .sweep = sweep("1e-4")}}};
  EXPECT_EQ(resolve_error(plan), "plan p: solver 'lemke': sweep 'mine' is given with two grids");
  plan.solvers[1].sweep = sweep("1e-6");
  EXPECT_EQ(resolve(plan).solvers.size(), 1U);
}

TEST(ResolveTest, PaperPlanGivesNoSolverAProblemItRefusesForItsKind) {
  const Study study = resolve(load_plan("paper"));
  for (const StudySolver& solver : study.solvers) {
    bool runs = false;
    for (std::size_t set = 0; set < study.sets.size(); ++set) {
      const bool frictional = study.sets[set].set->name().find("copositive") != std::string::npos;
      runs = runs || solver.takes(set, 0);
      if (!find_solver(solver.row.name).definition.capabilities.frictionless_only || !frictional) continue;
      EXPECT_FALSE(solver.takes(set, 0)) << solver.row.text() << " on " << study.sets[set].set->name();
    }
    EXPECT_TRUE(runs) << solver.row.text();
  }
}

TEST(ResolveTest, ASweepIsAnotherSolverThanTheSameOneAlone) {
  Plan plan;
  plan.sets = {{.pattern = "paper/monotone/exp1", .trials = 1}};
  plan.solvers = {PlannedSolver{.spec = {"lemke", {}}}, PlannedSolver{.spec = {"lemke", {}}},
                  PlannedSolver{.spec = {"lemke", {}}, .sweep = builtin_sweep("paper", {"lemke", {}})}};
  const Study study = resolve(plan);
  ASSERT_EQ(study.solvers.size(), 2U);
  EXPECT_EQ(study.solvers[1].cell_count(), 81);
  EXPECT_NE(study.solvers[0].row.id(), study.solvers[1].row.id());
}

}  // namespace
}  // namespace lcpbench::plan_test
