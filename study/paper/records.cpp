#include "study/paper/records.h"

#include <cmath>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/registry.h"
#include "core/spec.h"
#include "study/paper/grids.h"
#include "study/paper/solvability.h"

namespace lcpbench::paper {

namespace {

using Json = nlohmann::ordered_json;

Proportion share(std::int64_t part, std::int64_t whole) {
  return {static_cast<double>(part), static_cast<double>(whole)};
}

Json share_json(const Proportion& share) {
  const Interval interval = share.interval();
  return {{"share", share.value()}, {"low", interval.low}, {"high", interval.high}, {"of", share.trials}};
}

/// One record for each line below the heading. A number becomes one, an empty field null; no field has a comma.
Json published_records() {
  Json records = Json::array();
  std::vector<std::string> names;
  std::istringstream lines{std::string(kPublished)};
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> fields;
    std::istringstream rest(line + ",");
    for (std::string field; std::getline(rest, field, ',');) fields.push_back(field);
    if (names.empty()) {
      names = fields;
      continue;
    }
    Json record = Json::object();
    for (std::size_t i = 0; i < names.size(); ++i) {
      char* end = nullptr;
      const double number = std::strtod(fields[i].c_str(), &end);
      const bool is_number = i >= 6 && !fields[i].empty() && *end == '\0';
      record[names[i]] = fields[i].empty() ? Json() : is_number ? Json(number) : Json(fields[i]);
    }
    records.push_back(std::move(record));
  }
  return records;
}

/// Settings of a cell as tables write them: those off their defaults, "defaults" for none.
std::string settings_of(const Summary& summary, const Cell* cell) {
  if (cell == nullptr) return "";
  const std::string& settings = summary.solvers[cell->solver].settings;
  return settings.empty() ? "defaults" : settings;
}

/// What all records on a set of the paper begin with.
Json head(const PaperSet& set, const std::string& name, const std::string& solver) {
  const std::string family = family_of(solver);
  return {{"kind", set.kind},
          {"experiment", set.experiment},
          {"redundancy", set.redundant ? set.redundancy : ""},
          {"reading", set.redundancy},
          {"other_readings", set.other_readings},
          {"paper_solver", family.empty() ? Json() : Json(family)},
          {"set", name}};
}

Json head(const Summary& summary, const Grid& grid) {
  Json record = head(grid.problems, summary.sets[grid.set].name, grid.solver);
  record.update({{"solver", grid.label},
                 {"rules_2012", follows_rules_2012(grid.solver)},
                 {"refused", grid.refusal()},
                 {"parameterisations", grid.cells.size()}});
  return record;
}

/// The share of a set's problems that have a solution, by theory; NaN where there is none.
double solvable_share(const PaperSet& set) {
  static const double three = solvable_share_of_exp3();
  static const double four = solvable_share_of_exp4();
  if (set.kind != "monotone" || set.redundancy != "multiple") return kNoNumber;
  return set.experiment == "exp3" ? three : set.experiment == "exp4" ? four : kNoNumber;
}

/// The mean over a grid of the cells' shares of false claims, of as many trials as its smallest cell has.
Proportion false_claims(const Grid& grid) {
  double share = 0;
  for (const Cell* cell : grid.cells) {
    share += static_cast<double>(cell->false_claims()) / static_cast<double>(cell->trials);
  }
  const auto trials = static_cast<double>(grid.trials());
  return {share / static_cast<double>(grid.cells.size()) * trials, trials};
}

Json rate_records(const Summary& summary, const std::vector<Grid>& grids) {
  Json records = Json::array();
  for (const Grid& grid : grids) {
    const Cell& first = *grid.cells.front();
    for (const Measure measure : kMeasures) {
      const GridRange range = grid.refused() > 0 ? GridRange{} : range_of(grid, measure);
      const Cell::Half odd = range.chosen == nullptr ? Cell::Half{} : range.chosen->halves[1];
      Json record = head(summary, grid);
      record.update({{"solved_by", name_of(measure)},
                     {"worst", share_json(range.worst)},
                     {"average", share_json(range.average)},
                     {"best", share_json(range.best)},
                     {"sigma", range.sigma},
                     {"worst_settings", settings_of(summary, range.worst_cell)},
                     {"best_settings", settings_of(summary, range.best_cell)},
                     {"chosen_on_even", settings_of(summary, range.chosen)},
                     {"even", range.chosen_even.value()},
                     {"held_out", share_json(range.held_out)},
                     {"worst_held_out", share_json(range.worst_held_out)},
                     {"trials", grid.trials()},
                     {"base", grid.solver},
                     {"wrapped", wrapped_solver(grid.solver)},
                     {"sweep", grid.sweep},
                     {"isa", grid.isa},
                     {"build", grid.build},
                     {"false_claims", share_json(false_claims(grid))},
                     {"unsolvable", share_json(share(first.unsolvable_problems, first.trials))},
                     {"solvable", solvable_share(grid.problems)},
                     {"solved_odd", share_json(share(odd.solved, odd.trials))}});
      records.push_back(std::move(record));
    }
  }
  return records;
}

Json mean_json(const PooledMean& mean) {
  return {{"n", mean.values.count},
          {"mean", mean.values.mean},
          {"sigma", mean.values.sigma},
          {"max", mean.values.max},
          {"problems", mean.problems}};
}

Json measurement_records(const Summary& summary, const std::vector<Grid>& grids) {
  constexpr std::array<std::pair<Quantity, const char*>, 3> kQuantities{{{Quantity::kTimeSolved, "time_solved"},
                                                                         {Quantity::kTimeAll, "time_all"},
                                                                         {Quantity::kViolation, "violation"}}};
  Json records = Json::array();
  for (const Grid& grid : grids) {
    if (grid.refused() > 0) continue;
    for (const auto& [quantity, name] : kQuantities) {
      for (const Measure measure : kMeasures) {
        Json record = head(summary, grid);
        record.update({{"quantity", name},
                       {"solved_by", name_of(measure)},
                       {"best_settings", settings_of(summary, range_of(grid, measure).chosen)},
                       {"best", mean_json(at_best(grid, quantity, measure))},
                       {"all", mean_json(over_all(grid, quantity, measure))}});
        records.push_back(std::move(record));
      }
    }
  }
  return records;
}

/// The settings of a wrapped solver, those at their defaults too: a store leaves them out of a spec inside a setting.
Options settings_inside(const std::string& text) {
  const Spec spec = parse_spec(text);
  try {
    return find_solver(spec.name).definition.all_settings(spec.options);
  } catch (const InputError&) {  // a solver or setting of another version
    return spec.options;
  }
}

/// The number of a setting, in the options or in a spec that one of them holds. nullopt: there is none.
std::optional<double> find_number(const Options& options, std::string_view setting) {
  for (const auto& [key, value] : options) {
    if (key == setting) {
      char* end = nullptr;
      const double number = std::strtod(value.c_str(), &end);
      if (end != value.c_str() && *end == '\0' && std::isfinite(number)) return number;
    }
    if (key != "solver") continue;
    const std::optional<double> inside = find_number(settings_inside(value), setting);
    if (inside) return inside;
  }
  return std::nullopt;
}

/// Every cell on a set of the paper.
Json cell_records(const Summary& summary) {
  Json records = Json::array();
  for (const Cell& cell : summary.cells) {
    const SolverRow& solver = summary.solvers[cell.solver];
    const std::string& set = summary.sets[cell.set].name;
    const std::optional<PaperSet> problems = paper_set(set);
    if (!problems || cell.refused()) continue;
    Json record = head(*problems, set, solver.text());
    record.update({{"solver", solver.text()},
                   {"name", solver.name},
                   {"sweep", solver.sweep},
                   {"refused", cell.count(Claim::kUnsupported)},
                   {"pivot_tolerance", Json()},
                   {"zero_tolerance", Json()},
                   {"trials", cell.trials}});
    try {
      const Options options = parse_spec(solver.name + "{" + solver.all_settings + "}").options;
      for (const char* name : {"pivot_tolerance", "zero_tolerance"}) {
        record[name] = find_number(options, name).value_or(kNoNumber);
      }
    } catch (const InputError&) {  // a store of other hands may spell settings otherwise
    }
    for (const Measure measure : {Measure::kCriterion, Measure::kVerdict}) {
      record[name_of(measure)] = share_json(solved_share(cell, measure));
    }
    records.push_back(std::move(record));
  }
  return records;
}

/// Are two solvers at single settings compared in pairs: lemke with another solver of the paper on one set, and a
/// regularised solver on Experiment 6 with what it wraps on the same problems, Experiment 5?
bool paired(const Json& first, const Json& second) {
  const auto same = [&](const char* name) { return first[name] == second[name]; };
  if (!same("kind") || !same("reading")) return false;
  if (first["solver"] == "lemke") {
    return same("experiment") && (second["paper_solver"] == "PATH" || second["paper_solver"] == "IP");
  }
  const auto experiment = first["experiment"].get<std::string>();
  return experiment.starts_with("exp6") && second["experiment"] == "exp5" + experiment.substr(4) &&
         second["solver"] == wrapped_solver(first["solver"].get<std::string>());
}

/// The trials that both met and took, by seed and number.
PairedShares pair_by_trial(const Cell& first, const Cell& second) {
  std::map<std::pair<std::int64_t, std::int64_t>, const Outcome*> others;
  for (const Outcome& outcome : second.outcomes) others.emplace(std::pair{outcome.seed, outcome.trial}, &outcome);
  const auto counts = [](const Outcome& outcome) { return !outcome.unsolvable && !outcome.refused; };
  PairedShares pairs;
  for (const Outcome& outcome : first.outcomes) {
    const auto other = others.find({outcome.seed, outcome.trial});
    if (other == others.end() || !counts(outcome) || !counts(*other->second)) continue;
    pairs.add(outcome.solved, other->second->solved);
  }
  return pairs;
}

/// Cells at single settings have outcomes, those of sweeps have none.
Json pair_records(const Summary& summary) {
  std::vector<std::pair<const Cell*, Json>> cells;
  for (const Cell& cell : summary.cells) {
    const SolverRow& solver = summary.solvers[cell.solver];
    const std::optional<PaperSet> problems = paper_set(summary.sets[cell.set].name);
    if (!problems || !problems->other_readings.empty() || cell.outcomes.empty() || cell.refused()) continue;
    cells.emplace_back(&cell, head(*problems, summary.sets[cell.set].name, solver.text()));
    cells.back().second.update({{"solver", solver.text()}, {"isa", solver.isa}});
  }
  Json records = Json::array();
  for (const auto& [first, record] : cells) {
    for (const auto& [second, other] : cells) {
      const bool same_level = record["isa"] == other["isa"] || record["isa"] == "" || other["isa"] == "";
      if (!same_level || !paired(record, other)) continue;
      const PairedShares pairs = pair_by_trial(*first, *second);
      records.push_back(record);
      records.back().update({{"second", other["solver"]},
                             {"problems", pairs.problems()},
                             {"only_first", pairs.only_first},
                             {"only_second", pairs.only_second}});
    }
  }
  return records;
}

}  // namespace

Json paper_records(const Summary& summary) {
  const std::vector<Grid> all = grids(summary);
  return {{"published", published_records()},
          {"paper_rates", rate_records(summary, all)},
          {"paper_measurements", measurement_records(summary, all)},
          {"paper_cells", cell_records(summary)},
          {"paper_pairs", pair_records(summary)}};
}

}  // namespace lcpbench::paper
