#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "study/summary/coverage.h"
#include "study/summary/summary.h"

namespace lcpbench {

namespace {

nlohmann::ordered_json nullable(const std::string& text) {
  return text.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(text);
}

nlohmann::ordered_json spread_json(const Spread& values) {
  return {{"count", values.count},
          {"mean", values.mean},
          {"sigma", values.sigma},
          {"max", values.max},
          {"median", values.median}};
}

nlohmann::ordered_json claims_json(const Cell& cell) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const Claim claim : kAllClaims) {
    for (const Verdict verdict : kAllVerdicts) {
      json[to_string(claim)][to_string(verdict)] = cell.count(claim, verdict);
    }
  }
  return json;
}

/// What a solver at single settings has beyond the keys of a sweep's parameterisation.
void add_details(const Cell& cell, nlohmann::ordered_json& json) {
  json["time"]["criterion"] = spread_json(cell.criterion_time);
  json["time"]["all"]["median_low"] = cell.median_time.low;
  json["time"]["all"]["median_high"] = cell.median_time.high;
  for (std::size_t i = 0; i < kTimeParts.size(); ++i) json["time"]["parts_mean"][kTimeParts[i]] = cell.time_parts[i];
  json["time_ratio_low"] = cell.time_ratio.low;
  json["time_ratio_high"] = cell.time_ratio.high;
  json["time_ratio_problems"] = cell.paired;
  json["criterion_violation"] = spread_json(cell.criterion_violation);
  json["solver_error_m_per_s"] = spread_json(cell.solver_error);
  json["model_error_m_per_s"] = spread_json(cell.model_error);
  json["pivots"] = spread_json(cell.pivots);
  json["claims"] = claims_json(cell);
}

nlohmann::ordered_json cell_json(const Summary& summary, const Cell& cell) {
  const SolverRow& solver = summary.solvers[cell.solver];
  nlohmann::ordered_json json;
  json["set"] = summary.sets[cell.set].name;
  json["solver"] = solver.name;
  json["settings"] = solver.settings;
  json["library"] = solver.library;
  json["version"] = solver.version;
  json["isa"] = solver.isa;
  json["sweep"] = solver.sweep;
  json["model"] = to_string(solver.friction);
  json["trials"] = cell.trials;
  json["claimed"] = cell.count(Claim::kSolved);
  json["solved"] = cell.count(Verdict::kSolved);
  json["solved_1e6"] = cell.solved_1e6;
  json["solved_1e9"] = cell.solved_1e9;
  json["criterion"] = cell.criterion;
  json["criterion_any"] = cell.criterion_any;
  for (const Verdict verdict : kAllVerdicts) {
    if (verdict != Verdict::kSolved) json[to_string(verdict)] = cell.count(verdict);
  }
  json["unsolvable_problems"] = cell.unsolvable_problems;
  json["nearly_problems"] = cell.nearly_problems;
  json["nearly_solved"] = cell.nearly_solved;
  json["nearly_unsolvable"] = cell.nearly_unsolvable;
  json["false_claims"] = cell.false_claims();
  json["false_unsolvable"] = cell.false_unsolvable;
  json["gave_up"] = cell.gave_up();
  for (const Claim claim : {Claim::kTimeLimit, Claim::kUnsupported, Claim::kCrashed}) {
    json[to_string(claim)] = cell.count(claim);
  }
  json["rate"] = cell.rate();
  json["rate_low"] = cell.rate_interval.low;
  json["rate_high"] = cell.rate_interval.high;
  json["criterion_rate"] = cell.criterion_rate();
  json["time"]["solved"] = spread_json(cell.solved_time);
  json["time"]["all"] = spread_json(cell.all_time);
  json["time_ratio"] = cell.time_ratio.value;
  json["violation"] = spread_json(cell.violation);
  json["error"]["measure"] = nullable(cell.error_measure);
  json["error"]["answers"] = cell.error_count;
  json["error"]["median"] = cell.error_median;
  json["error"]["p99"] = cell.error_p99;
  json["error"]["max"] = cell.error_max;
  if (solver.sweep.empty()) add_details(cell, json);
  return json;
}

/// A rate over the parameterisations of a sweep: NaN if all problems are unsolvable, so that one of the rates is.
nlohmann::ordered_json range_json(const Summary& summary, const std::vector<const Cell*>& cells,
                                  double (Part::*rate)() const) {
  const auto rate_of = [rate](const Cell* cell) { return (cell->*rate)(); };
  const Cell* worst = *std::ranges::min_element(cells, {}, rate_of);
  const Cell* best = *std::ranges::max_element(cells, {}, rate_of);
  double sum = 0;
  for (const Cell* cell : cells) sum += rate_of(cell) / static_cast<double>(cells.size());
  const bool known = !std::isnan(sum);
  const auto settings = [&](const Cell* cell) { return known ? summary.solvers[cell->solver].settings : ""; };
  return {{"worst", known ? rate_of(worst) : kNoNumber},
          {"average", known ? std::clamp(sum, rate_of(worst), rate_of(best)) : kNoNumber},  // the sum is rounded
          {"best", known ? rate_of(best) : kNoNumber},
          {"worst_settings", settings(worst)},
          {"best_settings", settings(best)}};
}

double best_held_out(const std::vector<const Cell*>& cells) {
  const Cell* best = nullptr;
  for (const Cell* cell : cells) {
    if (std::isnan(cell->halves[0].rate())) continue;
    if (best == nullptr || cell->halves[0].rate() > best->halves[0].rate()) best = cell;
  }
  return best == nullptr ? kNoNumber : best->halves[1].rate();
}

nlohmann::ordered_json sweeps_json(const Summary& summary) {
  using Shared = std::array<std::string, 5>;  // what the parameterisations of one sweep have in common
  std::map<std::pair<std::size_t, Shared>, std::vector<const Cell*>> sweeps;  // by set
  for (const Cell& cell : summary.cells) {
    const SolverRow& solver = summary.solvers[cell.solver];
    if (solver.sweep.empty()) continue;
    const Shared shared{solver.name, solver.sweep, solver.isa, solver.library, solver.version};
    sweeps[{cell.set, shared}].push_back(&cell);
  }
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const auto& [key, cells] : sweeps) {
    const auto& [name, sweep, isa, library, version] = key.second;
    nlohmann::ordered_json& row = rows.emplace_back();
    row = {{"set", summary.sets[key.first].name},
           {"solver", name},
           {"sweep", sweep},
           {"isa", isa},
           {"library", library},
           {"version", version},
           {"cells", cells.size()},
           {"trials", std::ranges::min(cells, {}, &Cell::trials)->trials}};
    row.update(range_json(summary, cells, &Cell::rate));
    row["best_held_out"] = best_held_out(cells);
    row["criterion"] = range_json(summary, cells, &Cell::criterion_rate);
  }
  return rows;
}

}  // namespace

nlohmann::ordered_json summary_json(const Summary& summary) {
  nlohmann::ordered_json json;
  json["provenance"]["reference"] = nullable(summary.reference);
  json["provenance"]["runs"] = nlohmann::ordered_json::array();
  for (const RunSummary& run : summary.runs) {
    json["provenance"]["runs"].push_back({{"started", run.started}, {"provenance", run.provenance}});
  }
  json["coverage"] = coverage_json(summary.coverage);
  json["differences"] = {{"problems", summary.differing}, {"counts", summary.differences}};
  json["cells"] = nlohmann::ordered_json::array();
  for (const Cell& cell : summary.cells) json["cells"].push_back(cell_json(summary, cell));
  json["sweeps"] = sweeps_json(summary);
  return json;
}

}  // namespace lcpbench
