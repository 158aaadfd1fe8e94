// What a user relies on: however a study was run - threads, shards, interruptions - it ends with the same rows; and
// whatever a solver does, it leaves a row that says so.

#include "study/run/runner.h"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "adapters/worker/worker_client.h"
#include "core/error.h"
#include "core/io/problem_io.h"
#include "core/registry.h"
#include "core/same_bits.h"
#include "study/run/open_solver.h"
#include "study/store/answer_scan.h"
#include "study/store/merge.h"
#include "tests/study/study_runs.h"

namespace lcpbench::runner_test {
namespace {

Study small_study() {
  Plan plan;
  plan.name = "small";
  plan.trials = 8;
  plan.repeat_until_s = 0;
  plan.sets = {{.pattern = "paper/monotone/exp1"},
               {.pattern = "paper/monotone/exp3"},
               {.pattern = "paper/copositive/exp1{nc_max=3}", .trials = 3}};
  for (const char* solver : {"lemke", "lemke{engine=dense}", "primal_dual", "murty"}) {
    plan.solvers.push_back({.spec = parse_spec(solver)});
  }
  plan.solvers.back().every = 3;
  plan.solvers.push_back({.spec = parse_spec("lemke"), .sweep = builtin_sweep("paper", parse_spec("lemke"))});
  return resolve(plan);
}

/// Runs until `cells` are in the store, then stops as a signal would.
RunOutcome run_part(const Study& study, const std::filesystem::path& file, std::int64_t cells) {
  volatile std::sig_atomic_t stop = 0;
  RunOptions options;
  options.stop = &stop;
  options.on_progress = [&](const Progress& progress) { stop = progress.done >= cells ? 1 : 0; };
  return run_into(study, file, options);
}

TEST(RunnerTest, RunsEveryCellOnce) {
  const ScratchFolder folder;
  const RunOutcome outcome = run_into(small_study(), folder / "s.db");
  EXPECT_EQ(outcome.end, RunEnd::kComplete);
  EXPECT_EQ(outcome.progress.done, 2 * (8 * 84 + 3) + 3 * 84 + 1);
  EXPECT_EQ(Store::open_for_reading(folder / "s.db").cell_count(), outcome.progress.done);
  const RunOutcome again = run_into(small_study(), folder / "s.db");
  EXPECT_EQ(again.progress.total, 0);
  EXPECT_EQ(again.end, RunEnd::kComplete);
}

TEST(RunnerTest, ThreadsChangeNoRow) {
  const ScratchFolder folder;
  run_into(small_study(), folder / "one.db", {.jobs = 1});
  run_into(small_study(), folder / "three.db", {.jobs = 3});
  EXPECT_EQ(dump(folder / "one.db"), dump(folder / "three.db"));
}

/// More problems than may wait for the writer, several times over: however slowly it sees the stop, work is left.
TEST(RunnerTest, InterruptedAndResumedEqualsUnbroken) {
  const ScratchFolder folder;
  Plan plan;
  plan.name = "many";
  plan.trials = 1500;
  plan.repeat_until_s = 0;
  plan.sets = {{.pattern = "paper/monotone/exp1{nc_max=3}"}};
  plan.solvers = {{.spec = parse_spec("lemke")}, {.spec = parse_spec("primal_dual"), .every = 3}};
  const Study study = resolve(plan);
  run_into(study, folder / "whole.db");
  EXPECT_EQ(run_part(study, folder / "parts.db", 1).end, RunEnd::kStopped);
  EXPECT_NE(dump(folder / "parts.db"), dump(folder / "whole.db"));
  run_part(study, folder / "parts.db", 300);
  const RunOutcome last = run_into(study, folder / "parts.db");
  EXPECT_EQ(last.end, RunEnd::kComplete);
  EXPECT_GT(last.already_done, 0);
  EXPECT_EQ(dump(folder / "parts.db"), dump(folder / "whole.db"));
}

TEST(RunnerTest, AddedSolverRunsAlone) {
  const ScratchFolder folder;
  Study study = small_study();
  const StudySolver added = study.solvers.back();
  study.solvers.pop_back();
  run_into(study, folder / "s.db");
  study.solvers.push_back(added);
  EXPECT_EQ(run_into(study, folder / "s.db").progress.done, 19 * 81);
  run_into(study, folder / "whole.db");
  EXPECT_EQ(dump(folder / "s.db"), dump(folder / "whole.db"));
}

/// Lemke at six parameterisations as one sweep, and as six solvers by themselves.
Study swept_and_alone() {
  Plan plan;
  plan.name = "swept";
  plan.trials = 12;
  plan.repeat_until_s = 0;
  plan.sets = {{.pattern = "paper/monotone/exp2"},
               {.pattern = "paper/monotone/exp3"},
               {.pattern = "paper/copositive/exp2{nc_max=4}"}};
  const Spec lemke = parse_spec("lemke{cap=3n}");
  const Sweep grid{"six", {{"pivot_tolerance", {"1e-12", "1e-4"}}, {"zero_tolerance", {"1e-16", "1e-8", "1e-4"}}}};
  plan.solvers.push_back({.spec = lemke, .sweep = grid});
  for (const Spec& cell : sweep_cells(grid, lemke)) plan.solvers.push_back({.spec = cell});
  return resolve(plan);
}

TEST(RunnerTest, CellsOfASweepAnswerAsTheSolversDoAlone) {
  const ScratchFolder folder;
  const Study study = swept_and_alone();
  run_into(study, folder / "s.db");
  Store store = Store::open_for_reading(folder / "s.db");
  const std::int64_t sweep = study.solvers[0].row.id();
  std::int64_t compared = 0;
  AnswerScan(store).read(std::nullopt, [&](const AnsweredProblem& answered) {
    const ProblemRow& problem = answered.row;
    for (std::uint32_t cell = 0; cell < 6; ++cell) {
      const Answer swept = store.answer(problem.id, sweep, cell).value();
      const Answer alone = store.answer(problem.id, study.solvers[1 + cell].row.id()).value();
      EXPECT_EQ(swept.claim, alone.claim);
      EXPECT_EQ(swept.counters.pivots, alone.counters.pivots);
      EXPECT_EQ(swept.detail, alone.detail);
      EXPECT_TRUE(same_bits(swept.z, alone.z)) << problem.id << " cell " << cell;
      ++compared;
    }
  });
  EXPECT_EQ(compared, 3 * 12 * 6);
  EXPECT_EQ(store.database().integer("SELECT COUNT(*) FROM judged_cells swept JOIN solvers s ON s.id = swept.solver_id "
                                     "AND s.sweep <> '' JOIN judged_cells alone ON alone.problem_id = swept.problem_id "
                                     "AND alone.settings = swept.settings AND alone.solver_id <> swept.solver_id "
                                     "WHERE alone.verdict = swept.verdict AND alone.claim = swept.claim"),
            3 * 12 * 6);
  EXPECT_LT(store.database().integer("SELECT COUNT(*) FROM judged j JOIN solvers s ON s.id = j.solver_id "
                                     "WHERE s.sweep <> ''"),
            3 * 12 * 6 / 2);
}

TEST(RunnerTest, EqualAnswersToTwoModelsOfFrictionAreJudgedByTheirOwn) {
  const ScratchFolder folder;
  Plan plan;
  plan.name = "models";
  plan.trials = 1;
  plan.sets = {{.pattern = "rigid/frictional/exp1{nc_max=2}"}, {.pattern = "rigid/exp1{nc_max=2}"}};
  plan.solvers = {{.spec = parse_spec("cone_ipm"), .sweep = Sweep{"models", {{"cone", {"false", "true"}}}}}};
  Study study = resolve(plan);
  const OpenCell same = [] { return open_solver(parse_spec("cone_ipm{cone=true}")); };
  study.solvers[0].open_swept = [same] { return std::make_unique<SweptSolver>(std::vector{same, same}, true); };
  run_into(study, folder / "s.db");
  Store store = Store::open_for_reading(folder / "s.db");
  EXPECT_EQ(store.database().texts("SELECT s.name || ': ' || group_concat(model || ' ' || verdict, ', ') FROM "
                                   "(SELECT * FROM judged ORDER BY part) j JOIN sets s ON s.id = j.set_id "
                                   "GROUP BY j.set_id ORDER BY s.name"),
            (std::vector<std::string>{"rigid/exp1{nc_max=2}: pyramid solved",
                                      "rigid/frictional/exp1{nc_max=2}: pyramid wrong, cone solved"}));
}

TEST(RunnerTest, MergeOfSweepsThatWereGroupedOtherwiseIsAConflict) {
  const ScratchFolder folder;
  Study study = swept_and_alone();
  study.solvers.resize(1);
  run_into(study, folder / "a.db");
  // All cells but the last answer as the first cell does.
  std::vector<OpenCell> otherwise(6, [] { return open_solver(parse_spec("lemke{cap=3n,pivot_tolerance=1e-12}")); });
  otherwise.back() = [] { return open_solver(parse_spec("psor")); };
  study.solvers[0].open_swept = [otherwise] { return std::make_unique<SweptSolver>(otherwise, true); };
  run_into(study, folder / "b.db");
  EXPECT_FALSE(merge_stores(folder / "out.db", {folder / "a.db", folder / "b.db"}).conflicts.empty());
  EXPECT_FALSE(std::filesystem::exists(folder / "out.db"));
}

TEST(RunnerTest, MergedShardsEqualTheWhole) {
  const ScratchFolder folder;
  const Study study = small_study();
  const std::int64_t cells = run_into(study, folder / "whole.db").progress.done;
  std::int64_t sharded_cells = 0;
  for (std::int64_t shard = 0; shard < 3; ++shard) {
    const RunOutcome part =
        run_into(study, folder / (std::to_string(shard + 1) + ".db"), {.shard = shard, .shards = 3});
    EXPECT_GT(part.progress.done, 0);
    sharded_cells += part.progress.done;
  }
  EXPECT_EQ(sharded_cells, cells);
  const MergeOutcome outcome = merge_stores(folder / "out.db", {folder / "3.db", folder / "1.db", folder / "2.db"});
  EXPECT_TRUE(outcome.conflicts.empty());
  EXPECT_EQ(dump(folder / "out.db"), dump(folder / "whole.db"));
  merge_stores(folder / "out.db", {folder / "2.db"});
  EXPECT_EQ(dump(folder / "out.db"), dump(folder / "whole.db"));
}

TEST(RunnerTest, BudgetEndsTheRunWithoutBreakingAProblem) {
  const ScratchFolder folder;
  Study study = small_study();
  study.budget_s = 1e-9;
  const RunOutcome first = run_into(study, folder / "s.db");
  EXPECT_EQ(first.end, RunEnd::kOutOfBudget);
  EXPECT_LT(first.progress.done, first.progress.total);
  study.budget_s.reset();
  run_into(study, folder / "s.db");
  run_into(study, folder / "whole.db");
  EXPECT_EQ(dump(folder / "s.db"), dump(folder / "whole.db"));
}

TEST(RunnerTest, VerdictsFollowFromTheStoreWithoutSolvingAgain) {
  const ScratchFolder folder;
  const Study study = small_study();
  run_into(study, folder / "s.db");
  Store store = Store::open_for_reading(folder / "s.db");
  std::map<std::int64_t, Problem> problems;
  std::map<std::int64_t, std::string> names;
  for (const auto& [id, name] : store.sets()) names[id] = name;
  AnswerScan(store).read(std::nullopt, [&](const AnsweredProblem& answered) {
    const ProblemRow& row = answered.row;
    const Problem problem = open_set(names.at(row.set_id))->generate(row.seed, row.trial);
    EXPECT_EQ(problem_hash(problem), row.hash);
    problems[row.id] = problem;
  });
  std::int64_t last = -1;
  std::int64_t cells = 0;
  std::unique_ptr<Evaluator> evaluator;
  store.for_each_answer([&](const StoredAnswer& row) {
    cells += std::ssize(row.cells);
    if (row.problem_id != last) evaluator = std::make_unique<Evaluator>(problems.at(row.problem_id));
    last = row.problem_id;
    const Answer answer = *store.answer(row.problem_id, row.solver_id, static_cast<std::uint32_t>(row.part));
    const Errors errors = evaluator->errors(answer);
    EXPECT_EQ(errors.solved, row.errors.solved);
    if (errors.usable && problems.at(row.problem_id).contact() != nullptr) {
      EXPECT_EQ(errors.velocity_residual_relative, row.errors.velocity_residual_relative);
    }
    EXPECT_EQ(verdict(answer.claim, errors, row.truth), row.verdict);
  });
  EXPECT_EQ(cells, store.cell_count());
  EXPECT_GT(cells, 0);
}

// ------------------------------------------------------------------------- whatever a solver does

class Liar final : public TimedSolver {
 public:
  using Lie = std::function<void(const Problem&, Vector& z)>;
  explicit Liar(Lie lie) : lie_(std::move(lie)) {}
  void run(const Problem& problem, const TimedRequest&, TimedAnswer& result) override {
    result = {};
    result.answer.claim = Claim::kSolved;
    lie_(problem, result.answer.z);
  }

 private:
  Lie lie_;
};

StudySolver liar(const std::string& name, const Liar::Lie& lie) {
  return given_solver(name, [lie] { return std::make_unique<Liar>(lie); });
}

TEST(RunnerTest, LiesAreFalseClaims) {
  const ScratchFolder folder;
  Study study = small_study();
  study.solvers.clear();
  study.solvers.push_back(liar("zeros", [](const Problem& p, Vector& z) { z = Vector::Zero(p.size()); }));
  study.solvers.push_back(liar("nan", [](const Problem& p, Vector& z) {
    z = Vector::Constant(p.size(), std::numeric_limits<double>::quiet_NaN());
  }));
  study.solvers.push_back(liar("nothing", [](const Problem&, Vector& z) { z.resize(0); }));
  run_into(study, folder / "s.db");
  Store store = Store::open_for_reading(folder / "s.db");
  const auto caught = [&](const std::string& name) {
    return store.database().integer(
        "SELECT COUNT(*) FROM judged JOIN solvers s ON s.id = solver_id WHERE verdict = "
        "'wrong' AND s.name = '" +
        name + "'");
  };
  EXPECT_EQ(caught("nan"), 19);
  EXPECT_EQ(caught("nothing"), 19);
  EXPECT_GE(caught("zeros"), 14) << "where q >= 0 zeros are the answer";
}

TEST(RunnerTest, DefectOfOursEndsTheRunWithoutLosingRows) {
  const ScratchFolder folder;
  Study study = small_study();
  study.solvers.resize(1);
  study.solvers.push_back(liar("defect", [](const Problem& problem, Vector&) {
    if (problem.name().find("trial 5") != std::string::npos) throw std::logic_error("a defect");
  }));
  EXPECT_THROW(run_into(study, folder / "s.db"), std::logic_error);
  Store store = Store::open_for_reading(folder / "s.db");
  EXPECT_GT(store.cell_count(), 5);
}

/// What stands in the way of one problem: a file that cannot be read, a worker that does not start.
TEST(RunnerTest, WhatAUserCanMendEndsTheRunAndSaysHowToGoOn) {
  const ScratchFolder folder;
  Study study = small_study();
  study.solvers.resize(1);
  study.solvers.push_back(given_solver("worker", [] {
    return worker_solver("/nonexistent/worker", Spec{"fault", {}});
  }));
  const auto expect_way_on = [](const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("s.db: run the same command again to go on"), std::string::npos)
        << error.what();
  };
  try {
    run_into(study, folder / "s.db");
    ADD_FAILURE() << "the run was complete";
  } catch (const WorkerError& error) {
    EXPECT_NE(std::string(error.what()).find("/nonexistent/worker: No such file"), std::string::npos) << error.what();
    expect_way_on(error);
  }
  Store store = Store::open_for_reading(folder / "s.db");
  EXPECT_EQ(store.database().integer("SELECT COUNT(*) FROM answers WHERE claim = 'crashed'"), 0);
}

/// A step that an engine wrote wrongly costs no other one.
TEST(RunnerTest, AProblemThatCannotBeReadIsLeftOutAndNamed) {
  const ScratchFolder folder;
  Study study = small_study();
  std::filesystem::create_directory(folder / "problems");
  for (const char* name : {"a.json", "c.json"}) {
    write_problem(study.sets[0].set->generate(1, 0), folder / "problems" / name);
  }
  std::ofstream(folder / "problems/b.json") << "{}";
  study.sets = {{open_set("file:" + (folder / "problems").string()), 3}};
  study.solvers.resize(1);
  for (const std::int64_t done : {2, 0}) {  // and when it runs again
    const RunOutcome outcome = run_into(study, folder / "s.db");
    EXPECT_EQ(outcome.end, RunEnd::kComplete);
    EXPECT_EQ(outcome.progress.done, done);
    ASSERT_EQ(outcome.left_out.size(), 1U);
    EXPECT_EQ(outcome.left_out[0].rfind((folder / "problems/b.json").string() + ": ", 0), 0U) << outcome.left_out[0];
  }
  study.sets = {{open_set("file:" + (folder / "problems/b.json").string()), 1}};
  EXPECT_THROW(run_into(study, folder / "none.db"), InputError);
}

/// As where a scheduler ends the workers of a sweep together with the run.
TEST(RunnerTest, ASweepThatIsEndedWithTheRunDidNotCrash) {
  static volatile std::sig_atomic_t stop = 0;
  class Ended final : public TimedSolver {
   public:
    void run(const Problem&, const TimedRequest&, TimedAnswer& result) override {
      stop = 1;
      result = {};
      result.answer.claim = Claim::kCrashed;
      result.answer.detail = "killed by signal 15 (SIGTERM)";
    }
  };
  const ScratchFolder folder;
  Study study = small_study();
  study.solvers.erase(study.solvers.begin(), study.solvers.end() - 1);
  const std::vector<OpenCell> cells(81, [] { return std::make_unique<Ended>(); });
  study.solvers[0].open_swept = [cells] { return std::make_unique<SweptSolver>(cells, true); };
  EXPECT_EQ(run_into(study, folder / "s.db", {.stop = &stop}).end, RunEnd::kStopped);
  EXPECT_EQ(Store::open_for_reading(folder / "s.db").cell_count(), 0);
}

TEST(RunnerTest, OrderOfSolversTurnsWithTheTrial) {
  const ScratchFolder folder;
  std::vector<std::string> order;
  Study study = small_study();
  study.sets.resize(1);
  study.sets[0].trials = 3;
  study.solvers.clear();
  for (const char* name : {"a", "b", "c"}) {
    study.solvers.push_back(liar(name, [&order, name](const Problem&, Vector&) { order.emplace_back(name); }));
  }
  run_into(study, folder / "s.db");
  EXPECT_EQ(order, (std::vector<std::string>{"a", "b", "c", "b", "c", "a", "c", "a", "b"}));
}

/// The faulty worker. Only its hangs have a short time limit, so that they end soon.
class FaultySolver final : public TimedSolver {
 public:
  void run(const Problem& problem, const TimedRequest& request, TimedAnswer& result) override {
    TimedRequest impatient = request;
    if (problem.name() == "loop for ever" || problem.name() == "stop") impatient.time_limit_s = 0.3;
    worker_->run(problem, impatient, result);
  }

 private:
  std::unique_ptr<TimedSolver> worker_ = worker_solver(FAULT_WORKER, Spec{"fault", {}}, {.grace_s = 0.3});
};

TEST(RunnerTest, FaultsOfAWorkerLeaveRowsAndARunningStudy) {
  const ScratchFolder folder;
  const std::vector<std::pair<std::string, std::string>> expected{{"right", "solved"},
                                                                  {"segfault", "crashed"},
                                                                  {"abort", "crashed"},
                                                                  {"exit(0)", "crashed"},
                                                                  {"loop for ever", "time_limit"},
                                                                  {"garbage", "crashed"},
                                                                  {"zeros", "solved"},
                                                                  {"nan", "solved"},
                                                                  {"stop", "time_limit"},
                                                                  {"print", "solved"},
                                                                  {"close the socket", "crashed"}};
  std::vector<Problem> problems;
  for (const auto& [behaviour, claim] : expected) {
    problems.emplace_back(behaviour, Lcp{2.0 * Matrix::Identity(5, 5), Vector::Constant(5, -1.0)});
  }
  Study study;
  study.time_limit_s = 60;
  study.sets.push_back(
      {std::make_shared<GivenProblems>("given", problems), static_cast<std::int64_t>(problems.size())});
  study.solvers.push_back(given_solver("fault", [] { return std::make_unique<FaultySolver>(); }));
  study.solvers.push_back(given_solver("lemke", [] { return in_process(make_solver({"lemke", {}})); }));
  EXPECT_EQ(run_into(study, folder / "s.db", {.jobs = 2}).end, RunEnd::kComplete);
  Store store = Store::open_for_reading(folder / "s.db");
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const std::int64_t problem = problem_id("given", study.seed, static_cast<std::int64_t>(i));
    const std::optional<Answer> faulty = store.answer(problem, study.solvers[0].row.id());
    ASSERT_TRUE(faulty.has_value()) << expected[i].first;
    EXPECT_EQ(to_string(faulty->claim), expected[i].second) << expected[i].first << ": " << faulty->detail;
    const std::optional<Answer> right = store.answer(problem, study.solvers[1].row.id());
    ASSERT_TRUE(right.has_value());
    EXPECT_TRUE((right->z.array() == 0.5).all()) << expected[i].first;
  }
  EXPECT_EQ(store.database().integer("SELECT COUNT(*) FROM judged WHERE claim = 'solved' AND verdict = 'wrong'"), 2)
      << "zeros and nan";
}

}  // namespace
}  // namespace lcpbench::runner_test
