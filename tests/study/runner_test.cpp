// What a user relies on: however a study was run - threads, shards, interruptions - it ends with the same rows; and
// whatever a solver does, it leaves a row that says so.

#include "study/run/runner.h"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/io/problem_io.h"
#include "core/registry.h"
#include "core/same_bits.h"
#include "study/run/open_solver.h"
#include "study/store/answer_scan.h"
#include "study/store/merge.h"
#include "tests/support/study_support.h"

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
  SweptSolver sweep(cells, true);
  std::vector<SweptAnswer> answers;
  sweep.run(Problem("p", Lcp{Matrix::Identity(2, 2), Vector::Ones(2)}), {.repeat_until_s = 1}, answers);
  ASSERT_EQ(answers.size(), 3U);
  EXPECT_EQ(answers[0].cells, (std::vector<std::uint32_t>{0, 2}));
  EXPECT_EQ(answers[0].timed.times.solve_cpu_s, 2.0);
  EXPECT_EQ(answers[1].cells, (std::vector<std::uint32_t>{1}));
  EXPECT_EQ(answers[2].cells, (std::vector<std::uint32_t>{3})) << "0 and -0 are two answers";
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
  run(study, folder / "s.db");
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
  run(study, folder / "a.db");
  // All cells but the last answer as the first cell does.
  std::vector<OpenCell> otherwise(6, [] { return open_solver(parse_spec("lemke{cap=3n,pivot_tolerance=1e-12}")); });
  otherwise.back() = [] { return open_solver(parse_spec("psor")); };
  study.solvers[0].open_swept = [otherwise] { return std::make_unique<SweptSolver>(otherwise, true); };
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

}  // namespace
}  // namespace lcpbench::runner_test
