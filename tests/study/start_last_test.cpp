// `run --start last`: consecutive steps in order, each solver from its own last answer, and the same rows however the
// study was run.
#include <csignal>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/io/scenes_file.h"
#include "tests/support/box_stacks.h"
#include "study/run/runner.h"
#include "study/store/merge.h"
#include "tests/support/study_support.h"

namespace lcpbench::start_last_test {
namespace {

constexpr int kSteps = 12;

/// Steps of a stack that rests but for small disturbances, without the step `missing`.
void write_steps(const std::string& file, int height, int missing = -1, bool named = true) {
  ScenesWriter writer(file, {.scene = "stack", .engine = "test", .loop = "engine"});
  const testing::BoxStacks shape{.height = height, .fresh = 0.2};
  for (int k = 0; k < kSteps; ++k) {
    if (k == missing) continue;
    RigidScene scene = testing::box_stacks(shape);
    const Vector v = testing::falling_velocity(shape, k);
    SceneStep step{.step = k};
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      scene.bodies[b].linear_velocity = v.segment<3>(6 * static_cast<Index>(b));
      scene.bodies[b].angular_velocity = v.segment<3>(6 * static_cast<Index>(b) + 3);
    }
    for (std::size_t c = 0; c < scene.contacts.size() && named; ++c) step.contact_ids.push_back(std::to_string(c));
    step.problem = Problem("step", std::move(scene));
    writer.add(step);
  }
  writer.close();
}

Plan plan_of(const std::vector<std::string>& files, const std::vector<std::string>& solvers) {
  Plan plan;
  plan.name = "steps";
  plan.start_last = true;
  plan.repeat_until_s = 0;
  for (const std::string& file : files) plan.sets.push_back({.pattern = "file:" + file, .trials = 1000});
  for (const std::string& solver : solvers) plan.solvers.push_back({.spec = parse_spec(solver)});
  return plan;
}

RunOutcome run(const Study& study, const std::filesystem::path& file, const RunOptions& options = {}) {
  Store store = Store::open_for_writing(file);
  store.add_run("2026-01-01T00:00:00Z", "{}");
  return run_study(study, store, options);
}

class StartLastTest : public ::testing::Test {
 protected:
  StartLastTest() : low_(folder_ / "low.scenes"), high_(folder_ / "high.scenes") {
    write_steps(low_, 3);
    write_steps(high_, 5, 6);
  }
  Study study() const { return resolve(plan_of({low_, high_}, {"psor{max_iterations=8}", "auto", "cone_ipm"})); }

  const ScratchFolder folder_;
  const std::string low_;
  const std::string high_;
};

TEST_F(StartLastTest, SolversThatTakeAStartRunTwiceAndTheStoreTellsWhich) {
  const Study study = this->study();
  ASSERT_EQ(study.solvers.size(), 5U);
  EXPECT_EQ(study.solvers[1].row.text(), "psor{max_iterations=8,start=last}");
  EXPECT_EQ(study.solvers[3].row.text(), "auto{start=last}");
  ASSERT_EQ(study.skipped.size(), 1U);
  EXPECT_NE(study.skipped[0].find("cone_ipm: take no start"), std::string::npos) << study.skipped[0];
  run(study, folder_ / "s.db");
  Store store = Store::open_for_reading(folder_ / "s.db");
  std::map<std::int64_t, std::string> names;
  for (const StoredSolver& solver : store.solvers()) names[solver.id] = solver.row.text();
  std::map<std::string, double> error;
  std::map<std::string, int> from_nothing;
  std::map<std::string, int> solved;
  store.for_each_answer([&](const StoredAnswer& answer) {
    const std::string& name = names.at(answer.solver_id);
    error[name] += answer.errors.velocity_residual_relative;
    if (answer.detail.starts_with("from nothing")) ++from_nothing[name];
    if (answer.verdict == Verdict::kSolved) ++solved[name];
  });
  EXPECT_LT(error["psor{max_iterations=8,start=last}"], 0.5 * error["psor{max_iterations=8}"]);
  EXPECT_EQ(from_nothing["psor{max_iterations=8,start=last}"], 3) << "two files, one of which lacks a step";
  EXPECT_EQ(from_nothing["psor{max_iterations=8}"], 0);
  EXPECT_EQ(solved["auto{start=last}"], 2 * kSteps - 1);
}

TEST_F(StartLastTest, ProgramSaysItselfWhetherItTakesAStart) {
  EXPECT_EQ(resolve(plan_of({low_}, {"external{command=./p,warm_start=true}"})).solvers.size(), 2U);
  EXPECT_EQ(resolve(plan_of({low_}, {"external{command=./p}"})).solvers.size(), 1U);
}

TEST_F(StartLastTest, InterruptedAndResumedEqualsUnbroken) {
  const Study whole = study();
  run(whole, folder_ / "whole.db", {.jobs = 2});
  Study part = whole;
  for (StudySet& set : part.sets) set.trials = 5;
  run(part, folder_ / "parts.db");
  const RunOutcome rest = run(whole, folder_ / "parts.db");
  EXPECT_EQ(rest.end, RunEnd::kComplete);
  EXPECT_EQ(dump(folder_ / "parts.db"), dump(folder_ / "whole.db"));
  EXPECT_EQ(run(whole, folder_ / "parts.db").progress.total, 0);
}

TEST_F(StartLastTest, SequenceBelongsToOneShardAndMergedShardsEqualTheWhole) {
  const Study whole = study();
  const std::int64_t cells = run(whole, folder_ / "whole.db").progress.done;
  EXPECT_EQ(cells, 5 * (2 * kSteps - 1));
  std::int64_t sharded = 0;
  for (std::int64_t shard = 0; shard < 3; ++shard) {
    sharded += run(whole, folder_ / (std::to_string(shard) + ".db"), {.shard = shard, .shards = 3}).progress.done;
  }
  EXPECT_EQ(sharded, cells);
  merge_stores(folder_ / "out.db", {folder_ / "0.db", folder_ / "1.db", folder_ / "2.db"});
  EXPECT_EQ(dump(folder_ / "out.db"), dump(folder_ / "whole.db"));
}

TEST_F(StartLastTest, CrashLosesTheStartAndNotTheStudy) {
  class Crashing final : public TimedSolver {
   public:
    explicit Crashing(std::vector<bool>& started) : started_(started) {}
    void run(const Problem& problem, const TimedRequest& request, TimedAnswer& result) override {
      started_.push_back(request.start != nullptr);
      result = {};
      result.answer.claim = started_.size() == 3 ? Claim::kCrashed : Claim::kSolved;
      if (started_.size() != 3) result.answer.z = Vector::Ones(problem.size());
    }

   private:
    std::vector<bool>& started_;
  };
  Study study = resolve(plan_of({low_}, {"psor"}));
  std::vector<bool> started;
  study.solvers[1].open = [&] { return std::make_unique<Crashing>(started); };
  run(study, folder_ / "s.db");
  std::vector<bool> expected(kSteps, true);
  expected[0] = expected[3] = false;
  EXPECT_EQ(started, expected);
}

TEST_F(StartLastTest, ContactsWithoutNamesAreSolvedFromNothing) {
  const std::string unnamed = folder_ / "unnamed.scenes";
  write_steps(unnamed, 3, -1, false);
  run(resolve(plan_of({unnamed}, {"psor"})), folder_ / "s.db");
  Store store = Store::open_for_reading(folder_ / "s.db");
  int without_answer = 0;
  int without_names = 0;
  store.for_each_answer([&](const StoredAnswer& answer) {
    if (answer.detail.starts_with("from nothing: no answer to the step before")) ++without_answer;
    if (answer.detail.starts_with("from nothing: no names of the contacts")) ++without_names;
  });
  EXPECT_EQ(without_answer, 1);
  EXPECT_EQ(without_names, kSteps - 1);
}

TEST_F(StartLastTest, SetsWithoutConsecutiveStepsAreRefused) {
  Plan plan = plan_of({}, {"psor"});
  plan.sets = {{.pattern = "scene/stack/ode"}};
  EXPECT_THROW(resolve(plan), InputError);
  EXPECT_EQ(parse_plan(plan_json(plan), "p").start_last, true);
  EXPECT_THROW(parse_plan(R"({"format":"lcpbench-plan","version":1,"name":"p","start":"first","sets":["a"],)"
                          R"("solvers":["psor"]})",
                          "p"),
               InputError);
}

}  // namespace
}  // namespace lcpbench::start_last_test
