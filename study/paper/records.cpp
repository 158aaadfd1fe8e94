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

namespace lcpbench::paper {

namespace {

using Json = nlohmann::ordered_json;

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

/// What all records of a grid begin with.
Json head(const Summary& summary, const Grid& grid) {
  const std::optional<Family> family = family_of(grid.solver);
  const Experiment& experiment = *grid.problems.experiment;
  return {{"kind", name_of(grid.problems.kind)},
          {"experiment", experiment.name},
          {"redundancy", experiment.redundant ? grid.problems.redundancy() : ""},
          {"other_readings", grid.problems.other_readings()},
          {"paper_solver", family ? Json(name_of(*family)) : Json()},
          {"solver", grid.label},
          {"rules_2012", follows_rules_2012(grid.solver)},
          {"set", summary.sets[grid.set].name},
          {"refused", grid.refusal()},
          {"parameterisations", grid.cells.size()}};
}

Json rate_records(const Summary& summary, const std::vector<Grid>& grids) {
  Json records = Json::array();
  for (const Grid& grid : grids) {
    for (const Measure measure : kCounts) {
      const GridRange range = grid.refused() > 0 ? GridRange{} : range_of(grid, measure);
      Json record = head(summary, grid);
      record.update({{"solved_by", name_of(measure)},
                     {"worst", share_json(range.worst)},
                     {"average", share_json(range.average)},
                     {"best", share_json(range.best)},
                     {"sigma", range.best_cell == nullptr ? kNoNumber : range.sigma},
                     {"worst_settings", settings_of(summary, range.worst_cell)},
                     {"best_settings", settings_of(summary, range.best_cell)},
                     {"chosen_on_even", settings_of(summary, range.chosen)},
                     {"even", range.chosen_even.value()},
                     {"held_out", share_json(range.held_out)}});
      records.push_back(std::move(record));
    }
  }
  return records;
}

Json mean_json(const PooledMean& mean) {
  return {{"n", mean.values.count}, {"mean", mean.values.mean}, {"sigma", mean.values.sigma}, {"max", mean.values.max}};
}

Json measurement_records(const Summary& summary, const std::vector<Grid>& grids) {
  constexpr std::array<std::pair<Quantity, const char*>, 3> kQuantities{{{Quantity::kTimeSolved, "time_solved"},
                                                                         {Quantity::kTimeAll, "time_all"},
                                                                         {Quantity::kViolation, "violation"}}};
  Json records = Json::array();
  for (const Grid& grid : grids) {
    if (grid.refused() > 0) continue;
    for (const auto& [quantity, name] : kQuantities) {
      for (const Measure measure : kCounts) {
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

Json tolerance_records(const Summary& summary, const std::vector<Grid>& grids) {
  Json records = Json::array();
  for (const Grid& grid : grids) {
    for (const Cell* cell : grid.cells) {
      const SolverRow& solver = summary.solvers[cell->solver];
      try {
        const Options options = parse_spec(solver.name + "{" + solver.all_settings + "}").options;
        const std::optional<double> pivot = find_number(options, "pivot_tolerance");
        const std::optional<double> zero = find_number(options, "zero_tolerance");
        if (!pivot || !zero) continue;
        Json record{{"set", summary.sets[grid.set].name},
                    {"solver", grid.label},
                    {"pivot_tolerance", *pivot},
                    {"zero_tolerance", *zero},
                    {"trials", cell->trials}};
        for (const Measure measure : kMeasures) record[name_of(measure)] = share_json(solved_share(*cell, measure));
        records.push_back(std::move(record));
      } catch (const InputError&) {  // a store of other hands may spell settings otherwise
      }
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
          {"paper_tolerances", tolerance_records(summary, all)},
          {"paper_claims", all.empty() ? Json::array() : claims_json(test_claims(summary, all))}};
}

}  // namespace lcpbench::paper
