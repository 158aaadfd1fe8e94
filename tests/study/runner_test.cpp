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
#include "study/store/merge.h"
#include "core/same_bits.h"
#include "study/run/one_by_one.h"
#include "tests/support/study_support.h"

namespace lcpbench {
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

RunOutcome run(const Study& study, const std::filesystem::path& file, const RunOptions& options = {}) {
  Store store = Store::open_for_writing(file);
  store.add_run("2026-01-01T00:00:00Z", "{}");
  return run_study(study, store, options);
}

/// Runs until `cells` are in the store, then stops as a signal would.
RunOutcome run_part(const Study& study, const std::filesystem::path& file, std::int64_t cells) {
  volatile std::sig_atomic_t stop = 0;
  RunOptions options;
  options.stop = &stop;
  options.on_progress = [&](const Progress& progress) { stop = progress.done >= cells ? 1 : 0; };
  return run(study, file, options);
}

TEST(RunnerTest, RunsEveryCellOnce) {
  const ScratchFolder folder;
  const RunOutcome outcome = run(small_study(), folder / "s.db");
  EXPECT_EQ(outcome.end, RunEnd::kComplete);
  EXPECT_EQ(outcome.progress.done, 2 * (8 * 84 + 3) + 3 * 84 + 1);
  Store store = Store::open_for_reading(folder / "s.db");
  EXPECT_EQ(store.cell_count(), outcome.progress.done);
}

TEST(RunnerTest, ThreadsChangeNoRow) {
  const ScratchFolder folder;
  run(small_study(), folder / "one.db", {.jobs = 1});
  run(small_study(), folder / "three.db", {.jobs = 3});
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
  run(study, folder / "whole.db");
  EXPECT_EQ(run_part(study, folder / "parts.db", 1).end, RunEnd::kStopped);
  EXPECT_NE(dump(folder / "parts.db"), dump(folder / "whole.db"));
  run_part(study, folder / "parts.db", 300);
  const RunOutcome last = run(study, folder / "parts.db");
  EXPECT_EQ(last.end, RunEnd::kComplete);
  EXPECT_GT(last.already_done, 0);
  EXPECT_EQ(dump(folder / "parts.db"), dump(folder / "whole.db"));
}

TEST(RunnerTest, FinishedStudyHasNothingToDo) {
  const ScratchFolder folder;
  run(small_study(), folder / "s.db");
  const RunOutcome again = run(small_study(), folder / "s.db");
  EXPECT_EQ(again.progress.total, 0);
  EXPECT_EQ(again.end, RunEnd::kComplete);
}

TEST(RunnerTest, AddedSolverRunsAlone) {
  const ScratchFolder folder;
  Study study = small_study();
  const StudySolver added = study.solvers.back();
  study.solvers.pop_back();
  run(study, folder / "s.db");
  study.solvers.push_back(added);
  EXPECT_EQ(run(study, folder / "s.db").progress.done, 19 * 81);
  run(study, folder / "whole.db");
  EXPECT_EQ(dump(folder / "s.db"), dump(folder / "whole.db"));
}

/// By its description, whatever its settings say otherwise: a program's command may hold any words.
TEST(RunnerTest, FrictionModelIsThatOfTheSolversDescription) {
  const ScratchFolder folder;
  Plan plan;
  plan.name = "models";
  plan.trials = 1;
  plan.sets = {{.pattern = "rigid/frictional/exp1{nc_max=2}"}};
  Study study = resolve(plan);
  for (const char* spec : {"external{command=./mine {a,cone=true,b}}", "cone_ipm", "cone_ipm{cone=true}"}) {
    StudySolver& solver = study.solvers.emplace_back();
    solver.row = solver_row(parse_spec(spec));
    const bool cone = solver.row.text() == "cone_ipm{cone=true}";
    EXPECT_EQ(solver.row.friction, cone ? FrictionModel::kCone : FrictionModel::kPyramid) << spec;
    solver.open = [cone] { return in_process(make_solver(parse_spec(cone ? "cone_ipm{cone=true}" : "lemke"))); };
    solver.every.assign(1, {1});
  }
  run(study, folder / "s.db");
  Store store = Store::open_for_writing(folder / "s.db");
  for (const StoredSolver& solver : store.solvers()) {
    const bool cone = solver.row.text() == "cone_ipm{cone=true}";
    EXPECT_EQ(solver.row.friction, cone ? FrictionModel::kCone : FrictionModel::kPyramid) << solver.row.text();
    sqlite::Statement judged(store.database(), "SELECT model, truth, verdict FROM judged WHERE solver_id = ?");
    judged.bind_all(solver.id);
    ASSERT_TRUE(judged.step());
    EXPECT_EQ(judged.text(0), cone ? "cone" : "pyramid") << solver.row.text();
    EXPECT_EQ(judged.text(1), cone ? "unknown" : "solvable") << solver.row.text();
    EXPECT_EQ(judged.text(2), "solved") << solver.row.text();
  }
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
  run(study, folder / "s.db");
  Store store = Store::open_for_reading(folder / "s.db");
  const std::int64_t sweep = study.solvers[0].row.id();
  std::int64_t compared = 0;
  store.for_each_problem([&](const ProblemRow& problem) {
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

TEST(RunnerTest, CellsRunOneByOneGiveTheRowsOfCellsRunTogether) {
  const ScratchFolder folder;
  Study study = swept_and_alone();
  run(study, folder / "together.db");
  std::vector<OpenCell> cells;
  for (std::size_t i = 1; i < study.solvers.size(); ++i) cells.push_back(study.solvers[i].open);
  study.solvers[0].open_swept = [cells] { return one_by_one(cells, true); };
  run(study, folder / "apart.db");
  EXPECT_EQ(dump(folder / "apart.db"), dump(folder / "together.db"));
}

TEST(RunnerTest, EqualAnswersOfASweepShareARowAndTheirMeanTime) {
  class Fixed final : public TimedSolver {
   public:
    Fixed(double z, double solve_s) : z_(z), solve_s_(solve_s) {}
    void run(const Problem& problem, const TimedRequest& request, TimedAnswer& result) override {
      EXPECT_EQ(request.repeat_until_s, 0);
      result = {};
      result.answer.z = Vector::Constant(problem.size(), z_);
      result.times.solve_cpu_s = solve_s_;
    }

   private:
    double z_, solve_s_;
  };
  std::vector<OpenCell> cells;
  for (const auto& [z, solve_s] : {std::pair{1.0, 1.0}, {0.0, 7.0}, {1.0, 3.0}, {-0.0, 9.0}}) {
    cells.push_back([z = z, solve_s = solve_s] { return std::make_unique<Fixed>(z, solve_s); });
  }
  const auto sweep = one_by_one(cells, true);
  std::vector<SweptAnswer> answers;
  sweep->run(Problem("p", Lcp{Matrix::Identity(2, 2), Vector::Ones(2)}), {.repeat_until_s = 1}, answers);
  ASSERT_EQ(answers.size(), 3U);
  EXPECT_EQ(answers[0].cells, (std::vector<std::uint32_t>{0, 2}));
  EXPECT_EQ(answers[0].timed.times.solve_cpu_s, 2.0);
  EXPECT_EQ(answers[1].cells, (std::vector<std::uint32_t>{1}));
  EXPECT_EQ(answers[2].cells, (std::vector<std::uint32_t>{3})) << "0 and -0 are two answers";
}

TEST(RunnerTest, SweepThatLeavesOutACellIsADefectAndWritesNothing) {
  class Forgetful final : public SweptSolver {
   public:
    void run(const Problem&, const TimedRequest&, std::vector<SweptAnswer>& answers) override {
      answers = {{{0, 2}, {}}};
    }
  };
  const ScratchFolder folder;
  Study study = swept_and_alone();
  study.solvers.resize(1);
  study.solvers[0].open_swept = [] { return std::make_unique<Forgetful>(); };
  EXPECT_THROW(run(study, folder / "s.db"), std::logic_error);
  EXPECT_EQ(Store::open_for_reading(folder / "s.db").cell_count(), 0);
}

TEST(RunnerTest, MergeOfSweepsThatWereGroupedOtherwiseIsAConflict) {
  const ScratchFolder folder;
  Study study = swept_and_alone();
  study.solvers.resize(1);
  run(study, folder / "a.db");
  class Otherwise final : public SweptSolver {
   public:
    void run(const Problem&, const TimedRequest&, std::vector<SweptAnswer>& answers) override {
      answers = {{{0, 1, 2, 3}, {}}, {{4, 5}, {}}};
      answers[1].timed.answer.detail = "another";
    }
  };
  study.solvers[0].open_swept = [] { return std::make_unique<Otherwise>(); };
  run(study, folder / "b.db");
  EXPECT_FALSE(merge_stores(folder / "out.db", {folder / "a.db", folder / "b.db"}).conflicts.empty());
  EXPECT_FALSE(std::filesystem::exists(folder / "out.db"));
}

TEST(RunnerTest, SolversRunOnTheirSetsAndShareOfTrials) {
  Plan plan;
  plan.name = "limited";
  plan.trials = 10;
  plan.repeat_until_s = 0;
  plan.sets = {{.pattern = "paper/monotone/exp1", .share = 0.55},
               {.pattern = "paper/monotone/exp2{redundancy=combination}", .share = 0.1}};
  plan.solvers = {{.spec = parse_spec("lemke"), .every = 3, .sets = {"*exp1"}},
                  {.spec = parse_spec("lemke"), .sets = {"paper/*{redundancy=combination}"}},
                  {.spec = parse_spec("primal_dual"), .every = 2}};
  const ScratchFolder folder;
  run(resolve(plan), folder / "s.db");
  Store store = Store::open_for_reading(folder / "s.db");
  sqlite::Statement rows(
      store.database(),
      "SELECT v.name || ' ' || s.name || ' ' || j.trial FROM judged j JOIN sets s ON s.id = j.set_id "
      "JOIN solvers v ON v.id = j.solver_id ORDER BY 1");
  std::vector<std::string> ran;
  while (rows.step()) ran.emplace_back(rows.text(0));
  EXPECT_EQ(ran, (std::vector<std::string>{"lemke paper/monotone/exp1 0", "lemke paper/monotone/exp1 3",
                                           "lemke paper/monotone/exp2{redundancy=combination} 0",
                                           "primal_dual paper/monotone/exp1 0", "primal_dual paper/monotone/exp1 2",
                                           "primal_dual paper/monotone/exp1 4",
                                           "primal_dual paper/monotone/exp2{redundancy=combination} 0"}));
}

TEST(RunnerTest, MergedShardsEqualTheWhole) {
  const ScratchFolder folder;
  const Study study = small_study();
  const std::int64_t cells = run(study, folder / "whole.db").progress.done;
  std::int64_t sharded_cells = 0;
  for (std::int64_t shard = 0; shard < 3; ++shard) {
    const RunOutcome part = run(study, folder / (std::to_string(shard + 1) + ".db"), {.shard = shard, .shards = 3});
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

TEST(RunnerTest, MergeOfContradictionsNamesThemAndWritesNothing) {
  const ScratchFolder folder;
  const Study study = small_study();
  run(study, folder / "a.db");
  std::filesystem::copy_file(folder / "a.db", folder / "b.db");
  change_rows(folder / "b.db",
              "UPDATE answers SET claim = 'crashed' WHERE"
              " (problem_id, solver_id, part) IN (SELECT problem_id, solver_id, part FROM answers LIMIT 1)");
  const std::string before = dump(folder / "a.db");
  const MergeOutcome fresh = merge_stores(folder / "out.db", {folder / "a.db", folder / "b.db"});
  ASSERT_EQ(fresh.conflicts.size(), 1U);
  EXPECT_NE(fresh.conflicts[0].find("b.db: answers: paper/"), std::string::npos) << fresh.conflicts[0];
  EXPECT_EQ(fresh.conflicts[0].find("{}"), std::string::npos) << fresh.conflicts[0];
  EXPECT_FALSE(std::filesystem::exists(folder / "out.db"));
  EXPECT_EQ(merge_stores(folder / "a.db", {folder / "b.db"}).conflicts.size(), 1U);
  EXPECT_EQ(dump(folder / "a.db"), before);
}

std::string merge_error(const std::filesystem::path& out, const std::vector<std::filesystem::path>& inputs) {
  try {
    merge_stores(out, inputs);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(RunnerTest, DamagedInputOfAMergeIsNamed) {
  const ScratchFolder folder;
  const Study study = small_study();
  run(study, folder / "a.db");
  const std::filesystem::path b = folder / "b.db";
  const auto damaged = [&](const char* sql, bool with_checksums) {
    std::filesystem::copy_file(folder / "a.db", b, std::filesystem::copy_options::overwrite_existing);
    sqlite::Database(b, sqlite::Mode::kReadWrite).execute(sql);
    if (with_checksums) change_rows(b, "");
    return merge_error(folder / "out.db", {folder / "a.db", b});
  };
  EXPECT_EQ(damaged("UPDATE answers SET claim = 'sure'", true), b.string() + ": unknown claim 'sure'");
  for (const char* sql :
       {"DROP TABLE certificates", "ALTER TABLE timings ADD COLUMN x TEXT", "UPDATE timings SET solve_cpu_s = 0"}) {
    const std::string cause = damaged(sql, false);
    EXPECT_EQ(cause.rfind(b.string() + ": the store is damaged: table ", 0), 0U) << cause;
  }
  std::filesystem::copy_file(folder / "a.db", b, std::filesystem::copy_options::overwrite_existing);
  std::fstream damage(b, std::ios::in | std::ios::out | std::ios::binary);
  const auto size = static_cast<std::streamoff>(std::filesystem::file_size(b));
  for (std::streamoff at = size / 2; at < size; ++at) damage.seekp(at).put('\x5a');
  damage.close();
  const std::string cause = merge_error(folder / "out.db", {folder / "a.db", b});
  EXPECT_EQ(cause.rfind(b.string() + ": ", 0), 0U) << cause;
  EXPECT_NE(cause.find("damaged"), std::string::npos) << cause;
  EXPECT_FALSE(std::filesystem::exists(folder / "out.db"));
}

TEST(RunnerTest, BudgetEndsTheRunWithoutBreakingAProblem) {
  const ScratchFolder folder;
  Study study = small_study();
  study.budget_s = 1e-9;
  const RunOutcome first = run(study, folder / "s.db");
  EXPECT_EQ(first.end, RunEnd::kOutOfBudget);
  EXPECT_LT(first.progress.done, first.progress.total);
  study.budget_s.reset();
  run(study, folder / "s.db");
  run(study, folder / "whole.db");
  EXPECT_EQ(dump(folder / "s.db"), dump(folder / "whole.db"));
}

TEST(RunnerTest, VerdictsFollowFromTheStoreWithoutSolvingAgain) {
  const ScratchFolder folder;
  const Study study = small_study();
  run(study, folder / "s.db");
  Store store = Store::open_for_reading(folder / "s.db");
  std::map<std::int64_t, Problem> problems;
  std::map<std::int64_t, std::string> names;
  for (const auto& [id, name] : store.sets()) names[id] = name;
  store.for_each_problem([&](const ProblemRow& row) {
    const Problem problem = open_set(names.at(row.set_id))->generate(row.seed, row.trial);
    EXPECT_EQ(problem_hash(problem), row.hash);
    problems[row.id] = problem;
  });
  std::int64_t last = -1;
  std::int64_t cells = 0;
  std::unique_ptr<Evaluator> evaluator;
  store.for_each_answer([&](const StoredAnswer& row) {
    cells += std::ssize(*row.cells);
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
  study.solvers.push_back(given_solver("last answer", [] {
    auto last = std::make_shared<Vector>();
    return std::make_unique<Liar>([last](const Problem& problem, Vector& z) {
      z = *last;
      std::unique_ptr<Solver> honest = make_solver({"lemke", {}});
      Answer answer;
      honest->load(problem);
      honest->solve({}, answer);
      *last = answer.z;
    });
  }));
  run(study, folder / "s.db");
  Store store = Store::open_for_reading(folder / "s.db");
  std::map<std::int64_t, std::string> names;
  for (const StoredSolver& solver : store.solvers()) names[solver.id] = solver.row.name;
  std::map<std::string, int> caught;
  std::map<std::string, int> believed;
  store.for_each_answer([&](const StoredAnswer& cell) {
    ++(cell.verdict == Verdict::kWrong ? caught : believed)[names.at(cell.solver_id)];
  });
  // q >= 0 happens: there zeros are the answer, and passing the criterion by luck is not called wrong.
  for (const char* name : {"nan", "nothing"}) EXPECT_EQ(caught[name], 19) << name;
  for (const char* name : {"zeros", "last answer"}) EXPECT_GE(caught[name], 14) << name;
  sqlite::Statement rows(store.database(),
                         "SELECT COUNT(*) FROM judged WHERE verdict = 'solved' AND solver_id IN "
                         "(SELECT id FROM solvers WHERE name IN ('nan', 'nothing'))");
  ASSERT_TRUE(rows.step());
  EXPECT_EQ(rows.integer(0), 0);
}

TEST(RunnerTest, DefectOfOursEndsTheRunWithoutLosingRows) {
  const ScratchFolder folder;
  Study study = small_study();
  study.solvers.resize(1);
  study.solvers.push_back(liar("defect", [](const Problem& problem, Vector&) {
    if (problem.name().find("trial 5") != std::string::npos) throw std::logic_error("a defect");
  }));
  EXPECT_THROW(run(study, folder / "s.db"), std::logic_error);
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
    run(study, folder / "s.db");
    ADD_FAILURE() << "the run was complete";
  } catch (const WorkerError& error) {
    EXPECT_NE(std::string(error.what()).find("/nonexistent/worker: No such file"), std::string::npos) << error.what();
    expect_way_on(error);
  }
  std::filesystem::create_directory(folder / "problems");
  write_problem(study.sets[0].set->generate(1, 0), folder / "problems/a.json");
  std::ofstream(folder / "problems/b.json") << "{}";
  study.sets = {{open_set("file:" + (folder / "problems").string()), 2}};
  study.solvers.resize(1);
  try {
    run(study, folder / "s.db");
    ADD_FAILURE() << "the run was complete";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).rfind((folder / "problems/b.json").string() + ": ", 0), 0U) << error.what();
    expect_way_on(error);
  }
  Store store = Store::open_for_reading(folder / "s.db");
  EXPECT_GE(store.cell_count(), 1);
  EXPECT_EQ(store.database().integer("SELECT COUNT(*) FROM answers WHERE claim = 'crashed'"), 0);
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
  run(study, folder / "s.db");
  EXPECT_EQ(order, (std::vector<std::string>{"a", "b", "c", "b", "c", "a", "c", "a", "b"}));
}

TEST(RunnerTest, FaultsOfAWorkerLeaveRowsAndARunningStudy) {
  const ScratchFolder folder;
  const std::vector<std::pair<std::string, std::string>> expected{
      {"right", "solved"},    {"segfault", "crashed"},        {"abort", "crashed"},
      {"exit(0)", "crashed"}, {"_exit(0)", "crashed"},        {"loop for ever", "time_limit"},
      {"garbage", "crashed"}, {"huge z", "crashed"},          {"zeros", "solved"},
      {"nan", "solved"},      {"stop", "time_limit"},         {"wrong magic", "crashed"},
      {"print", "solved"},    {"close the socket", "crashed"}};
  std::vector<Problem> problems;
  for (const auto& [behaviour, claim] : expected) {
    problems.emplace_back(behaviour, Lcp{2.0 * Matrix::Identity(5, 5), Vector::Constant(5, -1.0)});
  }
  Study study;
  study.time_limit_s = 0.3;
  study.sets.push_back(
      {std::make_shared<GivenProblems>("given", problems), static_cast<std::int64_t>(problems.size())});
  study.solvers.push_back(given_solver("fault", [] {
    WorkerLimits limits;
    limits.grace_s = 0.3;
    return worker_solver(FAULT_WORKER, Spec{"fault", {}}, limits);
  }));
  study.solvers.push_back(given_solver("lemke", [] { return in_process(make_solver({"lemke", {}})); }));
  EXPECT_EQ(run(study, folder / "s.db", {.jobs = 2}).end, RunEnd::kComplete);
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
  sqlite::Statement false_claims(store.database(),
                                 "SELECT COUNT(*) FROM judged WHERE claim = 'solved' AND verdict = 'wrong'");
  ASSERT_TRUE(false_claims.step());
  EXPECT_EQ(false_claims.integer(0), 2);  // zeros and nan
}

}  // namespace
}  // namespace lcpbench
