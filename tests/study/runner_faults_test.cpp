// What a user relies on: whatever a solver does, it leaves a row that says so, and a run goes on.

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
#include "tests/support/study_support.h"

namespace lcpbench::runner_faults_test {
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
  EXPECT_EQ(run(study, folder / "s.db", {.stop = &stop}).end, RunEnd::kStopped);
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
  run(study, folder / "s.db");
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
  study.time_limit_s = 60;
  study.sets.push_back(
      {std::make_shared<GivenProblems>("given", problems), static_cast<std::int64_t>(problems.size())});
  study.solvers.push_back(given_solver("fault", [] { return std::make_unique<FaultySolver>(); }));
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
}  // namespace lcpbench::runner_faults_test
