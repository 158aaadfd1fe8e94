#include "study/run/shards.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include <fmt/format.h>

#include "core/error.h"
#include "study/run/study.h"

namespace lcpbench {
namespace {

using sqlite::Statement;

/// SolverRow::text() and the sweep of a solver v.
constexpr const char* kSolver = "v.name || CASE v.settings WHEN '' THEN '' ELSE '{' || v.settings || '}' END, v.sweep";

}  // namespace

const MeasuredCost* MeasuredCosts::of(const std::string& set, const StudySolver& solver) const {
  const auto found = cells.find({set, solver.row.text(), solver.row.sweep});
  return found == cells.end() ? nullptr : &found->second;
}

MeasuredCosts measured_costs(sqlite::Database& store) {
  MeasuredCosts costs;
  double total = 0;
  // x: what all cells of a solver cost on one problem. A cell that was repeated cost more than its time. What
  // nobody timed, as answers of `engine`, costs nothing.
  Statement query(store,
                  std::string("SELECT s.name, ") + kSolver + ", COUNT(*), AVG(x), AVG(x * x) FROM "
                  "(SELECT problem_id, solver_id, TOTAL((SELECT COUNT(*) FROM cell_groups g "
                  "WHERE g.group_id = a.group_id) * t.repeats * (t.setup_cpu_s + t.solve_cpu_s) + t.verify_s) AS x "
                  "FROM answers a LEFT JOIN timings t USING (problem_id, solver_id, part) GROUP BY 1, 2) "
                  "JOIN problems p ON p.id = problem_id JOIN sets s ON s.id = p.set_id "
                  "JOIN solvers v ON v.id = solver_id GROUP BY 1, 2, 3");
  while (query.step()) {
    const double count = query.real(3);
    const double mean = query.real(4);
    const double variance = count > 1 ? (query.real(5) - mean * mean) * count / (count - 1) : mean * mean;
    costs.cells[{std::string(query.text(0)), std::string(query.text(1)), std::string(query.text(2))}] = {
        mean, std::sqrt(std::max(0.0, variance)), count};
    total += count * mean;
  }
  // A run that ends adds a second row, with an empty `started`. The threads are those of the run that had the most
  // memory: SQLite takes them from the row of the maximum.
  Statement end(store,
                "SELECT MAX(json_extract(provenance, '$.memory_bytes')), json_extract(provenance, '$.jobs'), "
                "SUM(json_extract(provenance, '$.processor_s')), "
                "AVG(IFNULL(json_extract(provenance, '$.start_s'), 0)), COUNT(*), "
                "(SELECT COUNT(*) FROM runs WHERE started <> '') "
                "FROM runs WHERE started = '' AND json_valid(provenance)");
  if (!end.step() || end.is_null(0) || total <= 0) {
    throw InputError(store.file().string() + ": does not say what its run cost: none has ended, or it solved nothing");
  }
  costs.memory_bytes = end.real(0);
  costs.jobs = std::max(1, static_cast<int>(end.integer(1)));
  costs.start_s = end.real(3);
  costs.paid = (end.real(2) - end.real(4) * costs.start_s) / total;
  if (end.integer(4) < end.integer(5)) costs.paid = std::max(1.0, costs.paid);  // a run was killed: its cost is missing
  return costs;
}

std::vector<TrialClass> trial_classes(std::int64_t trials, const std::vector<std::int64_t>& steps) {
  if (trials <= 0 || steps.empty()) return {};
  std::int64_t period = 1;  // after so many trials the same steps divide again; at most `trials`
  for (const std::int64_t step : steps) {
    const std::int64_t factor = step / std::gcd(period, step);
    period = factor <= trials / period ? factor * period : trials;
  }
  std::map<std::int64_t, std::int64_t, std::greater<>> counts{{period, (trials - 1) / period + 1}};  // by multiple
  for (std::int64_t trial = 1; trial < period; ++trial) {
    std::int64_t multiple = 0;
    for (const std::int64_t step : steps) {
      if (trial % step == 0) multiple = std::lcm(std::max<std::int64_t>(multiple, 1), step);
    }
    if (multiple > 0) counts[multiple] += (trials - 1 - trial) / period + 1;
  }
  std::vector<TrialClass> classes;
  for (const auto& [multiple, count] : counts) classes.push_back({multiple, multiple == period ? 0 : multiple, count});
  return classes;
}

std::int64_t count_trials(std::int64_t trials, const std::vector<std::int64_t>& steps) {
  std::int64_t count = 0;
  for (const TrialClass& each : trial_classes(trials, steps)) count += each.count;
  return count;
}

std::vector<std::vector<DealtClass>> deal_problems(const Study& study, std::int64_t shards) {
  std::vector<StudySolver> solvers = study.solvers;
  solvers.insert(solvers.end(), study.left_out.begin(), study.left_out.end());
  std::vector<std::vector<DealtClass>> deal(study.sets.size());
  std::vector<std::tuple<double, std::size_t, std::size_t>> order;  // of sets and their classes, by falling cost
  std::int64_t whole_sets = 0;
  for (std::size_t set = 0; set < study.sets.size(); ++set) {
    std::vector<std::int64_t> steps;
    for (const StudySolver& solver : solvers) {
      if (set < solver.every.size()) steps.insert(steps.end(), solver.every[set].begin(), solver.every[set].end());
    }
    const bool whole = study.sets[set].in_order;
    const std::int64_t shard = whole ? whole_sets++ % shards : 0;
    for (const TrialClass& each : trial_classes(study.sets[set].trials, steps)) {
      if (whole) {
        deal[set].push_back({each, shard, whole});
        continue;
      }
      double cost = 0;  // as measured, nothing for an unmeasured solver; without costs the number of solvers
      for (const StudySolver& solver : solvers) {
        if (!solver.takes(set, each.trial)) continue;
        const MeasuredCost* measured = study.costs.of(study.sets[set].set->name(), solver);
        cost += study.costs.cells.empty() ? 1 : measured != nullptr ? measured->mean : 0;
      }
      order.emplace_back(-cost, set, deal[set].size());
      deal[set].push_back({each});
    }
  }
  std::sort(order.begin(), order.end());
  std::int64_t dealt = 0;
  for (const auto& [cost, set, place] : order) {
    deal[set][place].first = dealt % shards;
    dealt += deal[set][place].count;
  }
  return deal;
}

std::vector<ShardEstimate> estimate_shards(const Study& study, std::int64_t shards) {
  const auto deal = deal_problems(study, shards);
  std::vector<ShardEstimate> estimates(static_cast<std::size_t>(shards));
  for (std::int64_t shard = 0; shard < shards; ++shard) {
    ShardEstimate& estimate = estimates[static_cast<std::size_t>(shard)];
    estimate.processor_s = study.costs.start_s;
    double variance = 0;
    for (std::size_t set = 0; set < study.sets.size(); ++set) {
      double set_s = 0;
      double deviation = 0;  // solvers are slow on the same problems: their deviations add up
      for (const StudySolver& solver : study.solvers) {
        std::int64_t problems = 0;
        for (const DealtClass& each : deal[set]) {
          if (solver.takes(set, each.trial)) problems += each.dealt_to(shard, shards);
        }
        estimate.cells += problems * solver.cell_count();
        if (problems == 0) continue;
        const MeasuredCost* cost = study.costs.of(study.sets[set].set->name(), solver);
        if (cost == nullptr) {
          throw InputError(fmt::format("--costs: its store has no times of '{}' on the set '{}': run it on some trials",
                                       solver.row.text(), study.sets[set].set->name()));
        }
        const auto count = static_cast<double>(problems);
        set_s += study.costs.paid * count * cost->mean;
        deviation += cost->deviation * std::sqrt(count + count * count / cost->problems);
      }
      estimate.processor_s += set_s;
      if (study.sets[set].in_order) {
        estimate.serial_s = std::max(estimate.serial_s, set_s + 2 * study.costs.paid * deviation);
      }
      variance += deviation * deviation;
    }
    estimate.error_s = 2 * study.costs.paid * std::sqrt(variance);
  }
  return estimates;
}

std::int64_t done_cells(const Study& study, sqlite::Database& store) {
  Statement query(store, fmt::format("SELECT {}, COUNT(DISTINCT a.problem_id) FROM answers a "
                                     "JOIN problems p ON p.id = a.problem_id JOIN solvers v ON v.id = a.solver_id "
                                     "JOIN sets s ON s.id = p.set_id "
                                     "WHERE a.part = 0 AND p.seed = ? AND s.name = ? AND p.trial < ? GROUP BY 1, 2",
                                     kSolver));
  std::int64_t done = 0;
  for (const StudySet& set : study.sets) {
    const std::string name = set.set->name();
    query.reset();
    query.bind_all(static_cast<std::int64_t>(study.seed), std::string_view(name), set.trials);
    while (query.step()) {
      for (const StudySolver& solver : study.solvers) {
        if (solver.row.text() != query.text(0) || solver.row.sweep != query.text(1)) continue;
        done += solver.cell_count() * query.integer(2);
      }
    }
  }
  return done;
}

}  // namespace lcpbench
