// The work of a run is found as it goes: in the order and with the counts that a list of all of it would have.

#include "study/run/work_queue.h"

#include <algorithm>
#include <random>
#include <thread>
#include <tuple>

#include <gtest/gtest.h>

#include "study/run/runner.h"
#include "tests/support/study_support.h"

namespace lcpbench {
namespace {

bool any_divides(const std::vector<std::int64_t>& steps, std::int64_t trial) {
  return std::any_of(steps.begin(), steps.end(), [trial](std::int64_t step) { return trial % step == 0; });
}

TEST(TrialsTest, CountsAsCountingDoes) {
  std::minstd_rand random(16);
  const auto below = [&random](std::int64_t bound) { return static_cast<std::int64_t>(random()) % bound; };
  for (int round = 0; round < 3000; ++round) {
    const std::int64_t trials = below(200);
    const std::int64_t shards = 1 + below(round % 2 == 0 ? 1 : 12);
    const std::int64_t shard = below(shards);
    std::vector<std::int64_t> steps(static_cast<std::size_t>(below(5)));
    for (std::int64_t& step : steps) step = 1 + below(round % 3 == 0 ? 300 : 20);
    std::int64_t counted = 0;
    for (std::int64_t trial = shard; trial < trials; trial += shards) counted += any_divides(steps, trial) ? 1 : 0;
    EXPECT_EQ(count_trials(trials, steps, shard, shards), counted) << "round " << round;
    for (const std::int64_t step : steps) {
      const auto members = multiples_in_shard(step, shard, shards);
      const std::int64_t from = below(200);
      std::int64_t next = from;
      while (next < from + step * shards && !(next % step == 0 && next % shards == shard)) ++next;
      EXPECT_EQ(members.has_value(), next < from + step * shards) << "round " << round;
      if (members) {
        EXPECT_EQ(members->next(from), next) << "round " << round;
      }
    }
  }
  EXPECT_EQ(count_trials(100'000'000, {1}), 100'000'000);
  EXPECT_EQ(count_trials(100'000'000, {2, 3}, 0, 1), 66'666'667);
  constexpr std::int64_t kHuge = std::int64_t{1} << 62;  // what a damaged store may hold; no common multiple fits
  EXPECT_EQ(count_trials(kHuge, {kHuge / 2 + 3, 3}), (kHuge - 1) / 3 + 2);
}

Study uneven_study(std::int64_t trials = 30) {
  Plan plan;
  plan.name = "uneven";
  plan.trials = trials;
  plan.sets = {{.pattern = "paper/monotone/exp1"},
               {.pattern = "paper/monotone/exp2", .trials = 10},
               {.pattern = "paper/monotone/exp3"},
               {.pattern = "paper/copositive/exp1", .trials = 7}};
  plan.solvers = {{.spec = parse_spec("lemke"), .every = 2, .sets = {"*monotone*"}},
                  {.spec = parse_spec("primal_dual"), .every = 3},
                  {.spec = parse_spec("lemke"), .every = 5, .sweep = builtin_sweep("paper", parse_spec("lemke"))}};
  return resolve(plan);
}

using Place = std::pair<std::size_t, std::int64_t>;  // set and trial

/// All problems of a shard in the order of a stable sort by share.
std::vector<Place> listed(const Study& study, std::int64_t shard, std::int64_t shards) {
  std::vector<Place> places;
  for (std::size_t set = 0; set < study.sets.size(); ++set) {
    for (std::int64_t trial = shard; trial < study.sets[set].trials; trial += shards) {
      const auto takes = [&](const StudySolver& solver) { return solver.takes(set, trial); };
      if (std::any_of(study.solvers.begin(), study.solvers.end(), takes)) places.emplace_back(set, trial);
    }
  }
  const auto share = [&](const Place& place) {
    return (static_cast<double>(place.second) + 0.5) / static_cast<double>(study.sets[place.first].trials);
  };
  std::stable_sort(places.begin(), places.end(), [&](const Place& a, const Place& b) { return share(a) < share(b); });
  return places;
}

TEST(PlanWalkTest, PassesTheProblemsInTheOrderOfTheirShare) {
  const ScratchFolder folder;
  Store store = Store::open_for_writing(folder / "s.db");
  const Study study = uneven_study();
  std::int64_t cells = 0;
  for (const auto& [shard, shards] :
       std::vector<std::pair<int, int>>{{0, 1}, {0, 4}, {1, 4}, {2, 4}, {3, 4}, {29, 50}}) {
    PlanWalk walk(study, store, shard, shards);
    std::vector<Place> passed;
    while (!walk.ended()) {
      const std::optional<Task> task = walk.step();
      ASSERT_TRUE(task.has_value());
      EXPECT_TRUE(task->solvers.empty());
      passed.emplace_back(task->set, task->trial);
    }
    EXPECT_EQ(passed, listed(study, shard, shards)) << shard << " of " << shards;
    if (shards == 4) cells += walk.planned();
    if (shards == 1) cells -= walk.planned();
  }
  EXPECT_EQ(cells, 0) << "the shards together plan what the whole does";
}

TEST(PlanWalkTest, LeavesOutWhatTheStoreHas) {
  const ScratchFolder folder;
  Store store = Store::open_for_writing(folder / "s.db");
  Study study = uneven_study(6);
  for (StudySet& set : study.sets) set.trials = std::min<std::int64_t>(set.trials, 6);
  Study part = study;
  part.solvers.erase(part.solvers.begin());
  part.sets.resize(1);
  const std::int64_t done = run_study(part, store, {}).progress.done;
  PlanWalk walk(study, store, 0, 1);
  EXPECT_FALSE(walk.counted());
  std::int64_t missing = 0;
  std::int64_t complete = 0;
  while (!walk.ended()) {
    const std::optional<Task> task = walk.step();
    if (!task) {
      ++complete;
      continue;
    }
    for (std::uint32_t i = 0; i < study.solvers.size(); ++i) {
      const bool all = task->solvers.empty();
      const bool listed = std::count(task->solvers.begin(), task->solvers.end(), i) > 0;
      if ((all || listed) && study.solvers[i].takes(task->set, task->trial)) missing += study.solvers[i].cell_count();
      EXPECT_TRUE(task->set > 0 || i == 0 || !listed) << "trial " << task->trial;
    }
  }
  EXPECT_TRUE(walk.counted());
  EXPECT_EQ(complete, 2) << "trials 3 and 5 of the first set: lemke alone takes even ones only";
  EXPECT_EQ(walk.already_done(), done);
  EXPECT_EQ(walk.planned(), done + missing);
}

TEST(PlanWalkTest, TenToTheEightTrialsCostNoMoreThanTen) {
  const ScratchFolder folder;
  Store store = Store::open_for_writing(folder / "s.db");
  const Study study = uneven_study(100'000'000);
  PlanWalk walk(study, store, 0, 1);
  // Even trials; those that 3 divides; 81 cells on those that 5 divides. The sets of 10 and 7 trials are small.
  const std::int64_t large = 50'000'000 + 33'333'334 + 81 * 20'000'000;
  const std::int64_t small = (5 + 4 + 81 * 2) + (3 + 81 * 2);
  EXPECT_EQ(walk.planned(), 2 * large + small);
  const std::optional<Task> first = walk.step();
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(std::tuple(first->set, first->trial), std::tuple(std::size_t{0}, std::int64_t{0}));
}

TEST(TaskQueueTest, GivesInOrderAndWakesThoseWhoWait) {
  TaskQueue queue;
  queue.push({0, 7, {}});
  queue.push({0, 8, {}});
  queue.end();
  EXPECT_EQ(queue.pop()->trial, 7);
  EXPECT_EQ(queue.pop()->trial, 8);
  EXPECT_FALSE(queue.pop().has_value());

  TaskQueue closed;
  std::thread waiting([&closed] { EXPECT_FALSE(closed.pop().has_value()); });
  { const ClosedAtTheEnd guard(closed); }
  waiting.join();
  closed.push({0, 9, {}});
  EXPECT_EQ(closed.size(), 0U);
}

}  // namespace
}  // namespace lcpbench
