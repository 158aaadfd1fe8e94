#include "study/run/shards.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <nlohmann/json.hpp>

#include "study/run/study.h"
#include "study/run/trials.h"

namespace lcpbench {
namespace {

using sqlite::Statement;

/// A solver takes all trials of a class, or none. The common multiple is 0 for trial 0, which every step divides.
bool takes(const StudySolver& solver, const Deal::Class& each) { return solver.takes(each.set, each.multiple); }

std::string solver_text(const Statement& row, int column) {
  SolverRow solver;
  row.read(column, solver.name, solver.settings);
  return solver.text();
}

}  // namespace

const MeasuredCost* MeasuredCosts::of(const std::string& set, const StudySolver& solver) const {
  const auto found = cells.find({set, solver.row.text(), solver.row.sweep});
  return found == cells.end() ? nullptr : &found->second;
}

MeasuredCosts measured_costs(sqlite::Database& store) {
  MeasuredCosts costs;
  double total = 0;
  // A cell that was repeated cost more than its time; those of a sweep that share a row have its time each.
  Statement query(store,
                  "SELECT s.name, v.name, v.settings, v.sweep, COUNT(*), SUM(x), SUM(x * x) FROM "
                  "(SELECT problem_id, solver_id, SUM((SELECT COUNT(*) FROM cell_groups g WHERE g.group_id = a.group_id)"
                  " * t.repeats * (t.setup_cpu_s + t.solve_cpu_s) + t.verify_s) AS x "
                  "FROM timings t JOIN answers a USING (problem_id, solver_id, part) GROUP BY problem_id, solver_id) "
                  "JOIN problems p ON p.id = problem_id JOIN sets s ON s.id = p.set_id JOIN solvers v ON v.id = solver_id "
                  "GROUP BY s.id, v.name, v.settings, v.sweep ORDER BY 1, 2, 3, 4");
  while (query.step()) {
    const auto count = query.integer(4);
    const double mean = query.real(5) / static_cast<double>(count);
    const double variance = std::max(0.0, query.real(6) / static_cast<double>(count) - mean * mean);
    MeasuredCost& cost = costs.cells[{std::string(query.text(0)), solver_text(query, 1), std::string(query.text(3))}];
    cost = {mean, mean, count};
    if (count > 1) cost.deviation = std::sqrt(variance * static_cast<double>(count) / static_cast<double>(count - 1));
    total += query.real(5);
  }
  Statement ends(store, "SELECT provenance FROM runs WHERE started = ''");
  double processor_s = 0;
  while (ends.step()) {
    const auto end = nlohmann::json::parse(ends.text(0), nullptr, false);
    if (!end.is_object()) continue;
    processor_s += end.value("processor_s", 0.0);
    if (end.value("memory_bytes", 0.0) <= costs.memory_bytes) continue;
    costs.memory_bytes = end.value("memory_bytes", 0.0);
    costs.jobs = end.value("jobs", 1);
  }
  if (total > 0) costs.overhead = processor_s / total;
  return costs;
}

Deal::Deal(const Study& study, std::int64_t shards) : shards_(shards), steps_(study.sets.size()) {
  std::vector<const StudySolver*> solvers;
  for (const auto* list : {&study.solvers, &study.left_out}) {
    for (const StudySolver& solver : *list) solvers.push_back(&solver);
  }
  for (std::size_t set = 0; set < study.sets.size(); ++set) {
    std::set<std::int64_t> steps;
    for (const StudySolver* solver : solvers) {
      if (set < solver->every.size()) steps.insert(solver->every[set].begin(), solver->every[set].end());
    }
    steps_[set].assign(steps.begin(), steps.end());
    for (const TrialClass& trials : trial_classes(study.sets[set].trials, steps_[set])) {
      Class each{set, trials.multiple, trials.count};
      for (const StudySolver* solver : solvers) {
        if (!takes(*solver, each)) continue;
        const MeasuredCost* measured = study.costs.of(study.sets[set].set->name(), *solver);
        each.cost += !study.costs.cells.empty() ? (measured != nullptr ? measured->mean : 0) : 1;
      }
      classes_.push_back(each);
    }
  }
  std::stable_sort(classes_.begin(), classes_.end(), [](const Class& a, const Class& b) { return a.cost > b.cost; });
  std::int64_t dealt = 0;
  for (Class& each : classes_) {
    each.first = dealt % shards;
    dealt += each.problems;
  }
}

std::int64_t Deal::problems(const Class& each, std::int64_t shard) const {
  const std::int64_t turn = (shard - each.first + shards_) % shards_;
  return turn < each.problems ? (each.problems - 1 - turn) / shards_ + 1 : 0;
}

std::vector<ShardEstimate> estimate_shards(const Study& study, std::int64_t shards) {
  const Deal deal(study, shards);
  const double overhead = study.costs.overhead > 0 ? study.costs.overhead : 1;
  std::vector<ShardEstimate> estimates;
  for (std::int64_t shard = 0; shard < shards; ++shard) {
    ShardEstimate& estimate = estimates.emplace_back();
    double drawn = 0;                                   // variance of the sum of the problems' own costs
    std::vector<double> unsure(study.sets.size(), 0.0);  // by set: what the error of the means makes of it
    for (const Deal::Class& each : deal.classes()) {
      const std::int64_t problems = deal.problems(each, shard);
      double deviation = 0;  // solvers are slow on the same problems: their deviations add up
      bool any = false;
      for (const StudySolver& solver : study.solvers) {
        if (!takes(solver, each)) continue;
        any = true;
        estimate.cells += problems * solver.cell_count();
        const MeasuredCost* cost = study.costs.of(study.sets[each.set].set->name(), solver);
        if (cost == nullptr) {
          estimate.not_measured += problems * solver.cell_count();
          continue;
        }
        estimate.processor_s += overhead * static_cast<double>(problems) * cost->mean;
        deviation += cost->deviation;
        unsure[each.set] += static_cast<double>(problems) * cost->deviation / std::sqrt(cost->problems);
      }
      if (any) estimate.problems += problems;
      drawn += static_cast<double>(problems) * deviation * deviation;
    }
    for (const double error : unsure) drawn += error * error;
    estimate.error_s = 2 * overhead * std::sqrt(drawn);
  }
  return estimates;
}

std::int64_t done_cells(const Study& study, sqlite::Database& store) {
  std::map<std::pair<std::string, std::string>, std::int64_t> cells;
  for (const StudySolver& solver : study.solvers) cells[{solver.row.text(), solver.row.sweep}] = solver.cell_count();
  Statement query(store,
                  "SELECT v.name, v.settings, v.sweep, COUNT(DISTINCT a.problem_id) FROM answers a JOIN solvers v ON "
                  "v.id = a.solver_id WHERE a.part = 0 GROUP BY v.name, v.settings, v.sweep");
  std::int64_t done = 0;
  while (query.step()) {
    const auto solver = cells.find({solver_text(query, 0), std::string(query.text(2))});
    if (solver != cells.end()) done += solver->second * query.integer(3);
  }
  return done;
}

}  // namespace lcpbench
