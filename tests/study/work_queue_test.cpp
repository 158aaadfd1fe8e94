// The work of a run is found as it goes: in the order and with the counts that a list of all of it would have.

#include "study/run/work_queue.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <random>
#include <set>
#include <string>
#include <tuple>

#include <gtest/gtest.h>

#include "study/run/runner.h"
#include "study/run/shards.h"
#include "tests/support/study_support.h"
#include "tests/support/synthetic_store.h"

namespace lcpbench::work_queue_test {
namespace {

bool any_divides(const std::vector<std::int64_t>& steps, std::int64_t trial) {
  return std::any_of(steps.begin(), steps.end(), [trial](std::int64_t step) { return trial % step == 0; });
}

TEST(TrialsTest, CountsAsCountingDoes) {
  std::minstd_rand random(16);
  const auto below = [&random](std::int64_t bound) { return static_cast<std::int64_t>(random()) % bound; };
  for (int round = 0; round < 3000; ++round) {
    const std::int64_t trials = below(200);
    std::vector<std::int64_t> steps(static_cast<std::size_t>(below(5)));
    for (std::int64_t& step : steps) step = 1 + below(round % 3 == 0 ? 300 : 20);
    const std::vector<TrialClass> classes = trial_classes(trials, steps);
    std::map<std::vector<bool>, std::int64_t> counts;  // by the steps that divide
    const auto dividing = [&steps](std::int64_t trial) {
      std::vector<bool> divides;
      for (const std::int64_t step : steps) divides.push_back(trial % step == 0);
      return divides;
    };
    std::int64_t counted = 0;
    for (std::int64_t trial = 0; trial < trials; ++trial) {
      const auto of_trial = std::find_if(classes.begin(), classes.end(),
                                         [trial](const TrialClass& each) { return trial % each.multiple == 0; });
      EXPECT_EQ(any_divides(steps, trial), of_trial != classes.end()) << "round " << round;
      if (of_trial == classes.end()) continue;
      ++counted;
      ++counts[dividing(trial)];
      EXPECT_EQ(dividing(of_trial->trial), dividing(trial)) << "round " << round;
    }
    EXPECT_EQ(count_trials(trials, steps), counted) << "round " << round;
    EXPECT_EQ(classes.size(), counts.size()) << "round " << round;
    for (const TrialClass& each : classes) EXPECT_EQ(each.count, counts[dividing(each.trial)]) << "round " << round;
  }
  EXPECT_EQ(count_trials(100'000'000, {1}), 100'000'000);
  EXPECT_EQ(count_trials(100'000'000, {2, 3}), 66'666'667);
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

/// All problems in the order of a stable sort by share.
std::vector<Place> listed(const Study& study) {
  std::vector<Place> places;
  for (std::size_t set = 0; set < study.sets.size(); ++set) {
    for (std::int64_t trial = 0; trial < study.sets[set].trials; ++trial) {
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

/// The problems of a shard, as a run into an empty store passes them.
std::vector<Place> passed(const Study& study, std::int64_t shard, std::int64_t shards, std::int64_t* cells = nullptr) {
  static const ScratchFolder folder;
  static Store store = Store::open_for_writing(folder / "s.db");
  PlanWalk walk(study, store, shard, shards);
  std::vector<Place> places;
  while (const std::optional<Task> task = walk.next([] { return false; })) {
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < study.solvers.size(); ++i) {
      if (study.solvers[i].takes(task->set, task->trial)) all.push_back(i);
    }
    EXPECT_EQ(task->solvers, all);
    places.emplace_back(task->set, task->trial);
  }
  if (cells != nullptr) *cells += walk.planned();
  return places;
}

/// Names the solvers that run on a problem.
std::string takers(const Study& study, const Place& place) {
  std::string names = std::to_string(place.first);
  for (const StudySolver& solver : study.solvers) names += solver.takes(place.first, place.second) ? '1' : '0';
  return names;
}

/// A run of any number of shards does each problem once, in the order of shares; each shard gets as many problems of
/// each class, and in all, as any other, but for one.
TEST(PlanWalkTest, ShardsAreDisjointCompleteAndBalanced) {
  const Study study = uneven_study();
  Study priced = study;  // as if each solver cost the same: dealt alike
  for (const StudySet& set : study.sets) {
    for (const StudySolver& solver : study.solvers) {
      priced.costs.cells[{set.set->name(), solver.row.text(), solver.row.sweep}] = {1, 0, 1};
    }
  }
  const std::vector<Place> all = listed(study);
  std::int64_t cells_of_all = 0;
  EXPECT_EQ(passed(study, 0, 1, &cells_of_all), all);
  for (const std::int64_t shards : {2, 5, 6, 30, 200}) {
    std::vector<Place> together;
    std::int64_t cells = 0;
    std::map<std::string, std::set<std::int64_t>> counts;  // by class: the numbers that shards got
    const std::vector<ShardEstimate> estimates = estimate_shards(priced, shards);
    for (std::int64_t shard = 0; shard < shards; ++shard) {
      std::int64_t cells_of_shard = 0;
      const std::vector<Place> part = passed(study, shard, shards, &cells_of_shard);
      std::vector<Place> in_order;
      std::copy_if(all.begin(), all.end(), std::back_inserter(in_order),
                   [&](const Place& place) { return std::count(part.begin(), part.end(), place) > 0; });
      EXPECT_EQ(part, in_order) << shard << " of " << shards;
      std::map<std::string, std::int64_t> mine;
      for (const Place& place : all) mine[takers(study, place)] += 0;
      for (const Place& place : part) ++mine[takers(study, place)];
      for (const auto& [name, count] : mine) counts[name].insert(count);
      counts["all"].insert(std::ssize(part));
      together.insert(together.end(), part.begin(), part.end());
      cells += cells_of_shard;
      EXPECT_EQ(estimates[static_cast<std::size_t>(shard)].cells, cells_of_shard);
    }
    EXPECT_EQ(cells, cells_of_all);
    std::vector<Place> sorted = all;
    std::sort(sorted.begin(), sorted.end());
    std::sort(together.begin(), together.end());
    EXPECT_EQ(together, sorted) << shards << " shards";
    for (const auto& [name, numbers] : counts) {
      EXPECT_LE(*numbers.rbegin() - *numbers.begin(), 1) << name << " of " << shards;
    }
  }
}

/// A machine without a library leaves the problems of the others where they are.
TEST(PlanWalkTest, AMachineWithoutASolverDealsAlike) {
  const Study whole = uneven_study();
  Study lacking = uneven_study();
  lacking.left_out = {lacking.solvers[2]};
  lacking.solvers.pop_back();
  for (std::int64_t shard = 0; shard < 4; ++shard) {
    std::vector<Place> expected;
    for (const Place& place : passed(whole, shard, 4)) {
      const auto takes = [&](const StudySolver& solver) { return solver.takes(place.first, place.second); };
      if (std::any_of(lacking.solvers.begin(), lacking.solvers.end(), takes)) expected.push_back(place);
    }
    EXPECT_EQ(passed(lacking, shard, 4), expected);
  }
}

/// By measured times, no two shards differ by more than the dearest problem; without them, they can.
TEST(PlanWalkTest, MeasuredCostsBalanceWhatCountsCannot) {
  Study study = uneven_study(5);
  for (StudySet& set : study.sets) set.trials = 5;
  double dearest = 0;
  for (std::size_t set = 0; set < study.sets.size(); ++set) {
    const double cost = set == 2 ? 1000 : 1;
    for (const StudySolver& solver : study.solvers) {
      study.costs.cells[{study.sets[set].set->name(), solver.row.text(), solver.row.sweep}] = {cost, 0, 3};
    }
    dearest = std::max(dearest, 3 * cost);
  }
  const std::vector<ShardEstimate> estimates = estimate_shards(study, 4);
  const auto [least, most] = std::minmax_element(
      estimates.begin(), estimates.end(), [](const auto& a, const auto& b) { return a.processor_s < b.processor_s; });
  EXPECT_LE(most->processor_s - least->processor_s, dearest);
  std::size_t problems = 0;
  for (std::int64_t shard = 0; shard < 4; ++shard) problems += passed(study, shard, 4).size();
  EXPECT_EQ(problems, listed(study).size());
}

/// What is solved in order takes its time, however many threads a shard has.
TEST(PlanWalkTest, ASetInOrderIsTheWorkOfOneThread) {
  Study study = uneven_study(5);
  for (const StudySet& set : study.sets) {
    for (const StudySolver& solver : study.solvers) {
      study.costs.cells[{set.set->name(), solver.row.text(), solver.row.sweep}] = {1, 0, 3};
    }
  }
  EXPECT_EQ(estimate_shards(study, 1)[0].serial_s, 0);
  const double all_s = estimate_shards(study, 1)[0].processor_s;
  for (StudySet& set : study.sets) set.in_order = true;
  const ShardEstimate in_order = estimate_shards(study, 1)[0];
  EXPECT_EQ(in_order.processor_s, all_s);
  EXPECT_GE(in_order.serial_s, all_s / static_cast<double>(study.sets.size()));
  EXPECT_LT(in_order.serial_s, all_s);
}

/// A run may pay less or more than the sum of its times.
TEST(ShardCostTest, IsWhatTheRunPaidAndNotTheSumOfTimes) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  const std::int64_t lemke = made.solver("lemke");
  for (std::int64_t trial = 0; trial < 10; ++trial)
    made.problem("paper/monotone/exp1", trial, {{lemke, {.time_s = 1}}});
  made.store().begin();
  made.store().add_run("", R"({"jobs": 1, "start_s": 0.5, "processor_s": 1.5, "memory_bytes": 1000000})");
  made.store().commit();
  const auto paid = [&] {
    const MeasuredCosts costs = measured_costs(made.store().database());
    EXPECT_EQ(costs.start_s, 0.5);
    return 10 * costs.paid * costs.cells.begin()->second.mean;
  };
  EXPECT_NEAR(paid(), 1, 1e-9);
  made.store().begin();
  made.store().add_run("2026-02-01T12:00:00Z", "{}");
  made.store().commit();
  EXPECT_GE(paid(), 9.9) << "a run was killed: what it paid is not known";
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
  while (const std::optional<Task> task = walk.next([] { return false; })) {
    for (std::uint32_t i = 0; i < study.solvers.size(); ++i) {
      const bool listed = std::count(task->solvers.begin(), task->solvers.end(), i) > 0;
      if (listed) missing += study.solvers[i].cell_count();
      EXPECT_TRUE(task->set > 0 || i == 0 || !listed) << "trial " << task->trial;
    }
  }
  EXPECT_TRUE(walk.counted());
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
  const std::optional<Task> first = walk.next([] { return false; });
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(std::tuple(first->set, first->trial), std::tuple(std::size_t{0}, std::int64_t{0}));
}

}  // namespace
}  // namespace lcpbench::work_queue_test
