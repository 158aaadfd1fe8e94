#include "study/commands/speed_bench.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "generators/sets.h"
#include "study/run/open_solver.h"
#include "study/statistics/statistics.h"
#include "study/run/study.h"

namespace lcpbench {
namespace {

struct Contender {
  SolverRow row;
  std::unique_ptr<TimedSolver> solver;
};

struct Measured {
  double time_s = 0;  ///< sum over the rounds so far
  bool verified = true;
};

double cpu_time_s(const SolveTimes& times) { return times.setup_cpu_s + times.solve_cpu_s; }

bool stopped(const BenchPlan& plan) { return plan.stop != nullptr && *plan.stop != 0; }

/// Contender 0 is the reference. None where `stop` was raised.
std::vector<Measured> measure(const Problem& problem, std::vector<Contender>& contenders, const BenchPlan& plan) {
  TimedRequest request;
  request.time_limit_s = plan.time_limit_s;
  request.repeat_until_s = plan.repeat_until_s;
  Evaluator evaluator(problem);
  std::vector<Measured> measured(contenders.size());
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < contenders.size(); ++i) order.push_back(i);
  for (int round = 0; round < 2; ++round) {
    for (const std::size_t i : order) {
      if (stopped(plan)) return {};
      TimedAnswer timed;
      contenders[i].solver->run(problem, request, timed);
      measured[i].time_s += 0.5 * cpu_time_s(timed.times);
      measured[i].verified = measured[i].verified && evaluator.errors(timed.answer).solved;
    }
    std::reverse(order.begin(), order.end());
  }
  return measured;
}

/// Times of the problems that count, in pairs.
struct Pairs {
  std::vector<double> reference;
  std::vector<double> solver;
};

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double geometric_mean_ratio(const Pairs& pairs) {
  double sum = 0;
  for (std::size_t i = 0; i < pairs.solver.size(); ++i) sum += std::log(pairs.reference[i] / pairs.solver[i]);
  return std::exp(sum / static_cast<double>(pairs.solver.size()));
}

BenchCell summarise(const std::string& set, const SolverRow& solver, std::int64_t problems, const Pairs& pairs) {
  const Estimate speedup = ratio_of_sums(pairs.reference, pairs.solver);
  return {.set = set,
          .solver = solver,
          .problems = problems,
          .timed = static_cast<std::int64_t>(pairs.solver.size()),
          .speedup_mean = speedup.value,
          .speedup_low = speedup.low,
          .speedup_high = speedup.high,
          .speedup_geomean = geometric_mean_ratio(pairs),
          .reference_mean_s = mean(pairs.reference),
          .solver_mean_s = mean(pairs.solver)};
}

std::vector<BenchCell> bench_set(const std::string& name, const BenchPlan& plan, std::vector<Contender>& contenders) {
  const std::unique_ptr<ProblemSet> set = open_set(name);
  const std::int64_t planned = std::min(plan.problems, set->count().value_or(plan.problems));
  std::vector<Pairs> pairs(contenders.size());
  std::int64_t problems = 0;
  for (; problems < planned; ++problems) {
    const std::vector<Measured> measured = measure(set->generate(plan.seed, problems), contenders, plan);
    if (measured.empty()) break;
    for (std::size_t i = 1; i < contenders.size(); ++i) {
      if (!measured[0].verified || !measured[i].verified) continue;
      pairs[i].reference.push_back(measured[0].time_s);
      pairs[i].solver.push_back(measured[i].time_s);
    }
  }
  std::vector<BenchCell> cells;
  for (std::size_t i = 1; i < contenders.size(); ++i) {
    cells.push_back(summarise(set->name(), contenders[i].row, problems, pairs[i]));
  }
  return cells;
}

}  // namespace

std::vector<BenchCell> run_bench(const BenchPlan& plan, const std::function<void(const std::string&)>& on_set) {
  std::vector<Contender> contenders;
  contenders.push_back({solver_row(plan.reference), open_solver(plan.reference)});
  for (const Spec& solver : plan.solvers) contenders.push_back({solver_row(solver), open_solver(solver)});
  std::vector<std::string> sets;
  for (const std::string& pattern : plan.sets) {
    for (std::string& name : expand_sets(pattern)) sets.push_back(std::move(name));
  }
  std::vector<BenchCell> cells;
  for (const std::string& set : sets) {
    if (stopped(plan)) break;
    on_set(set);
    for (BenchCell& cell : bench_set(set, plan, contenders)) cells.push_back(std::move(cell));
  }
  return cells;
}

}  // namespace lcpbench
