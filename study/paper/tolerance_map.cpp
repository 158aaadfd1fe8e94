#include "study/paper/tolerance_map.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "core/error.h"
#include "core/registry.h"
#include "study/paper/tables.h"

namespace lcpbench::paper {

namespace {

using Json = nlohmann::ordered_json;

struct Tolerances {
  double pivot = 0;
  double zero = 0;
};

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

std::optional<Tolerances> tolerances_of(const SolverRow& solver) {
  if (solver.all_settings.empty()) return std::nullopt;
  try {
    const Options options = parse_spec(solver.name + "{" + solver.all_settings + "}").options;
    const std::optional<double> pivot = find_number(options, "pivot_tolerance");
    const std::optional<double> zero = find_number(options, "zero_tolerance");
    if (pivot && zero) return Tolerances{*pivot, *zero};
  } catch (const InputError&) {  // a store of other hands may spell settings otherwise: it has no map
  }
  return std::nullopt;
}

void insert_sorted(std::vector<double>& values, double value) {
  const auto at = std::lower_bound(values.begin(), values.end(), value);
  if (at == values.end() || *at != value) values.insert(at, value);
}

std::size_t index_of(const std::vector<double>& values, double value) {
  return static_cast<std::size_t>(std::lower_bound(values.begin(), values.end(), value) - values.begin());
}

std::optional<ToleranceMap> map_of(const Summary& summary, const Grid& grid) {
  ToleranceMap map{&grid, {}, {}, {}};
  std::vector<Tolerances> tolerances;
  for (const Cell* cell : grid.cells) {
    const std::optional<Tolerances> found = tolerances_of(summary.solvers[cell->solver]);
    if (!found) return std::nullopt;
    tolerances.push_back(*found);
    insert_sorted(map.pivot_tolerances, found->pivot);
    insert_sorted(map.zero_tolerances, found->zero);
  }
  if (map.pivot_tolerances.size() < 2 || map.zero_tolerances.size() < 2) return std::nullopt;
  map.cells.assign(map.pivot_tolerances.size() * map.zero_tolerances.size(), nullptr);
  for (std::size_t i = 0; i < tolerances.size(); ++i) {
    const Cell*& place = map.cells[index_of(map.zero_tolerances, tolerances[i].zero) * map.pivot_tolerances.size() +
                                   index_of(map.pivot_tolerances, tolerances[i].pivot)];
    if (place == nullptr) place = grid.cells[i];
  }
  return map;
}

Json record(const std::string& set, const std::string& solver, double pivot, double zero, const Cell* cell) {
  Json json{{"set", set}, {"solver", solver}, {"pivot_tolerance", pivot}, {"zero_tolerance", zero}};
  json["trials"] = cell == nullptr ? Json() : Json(cell->trials);
  for (const Measure measure : kMeasures) {
    json[name_of(measure)] = share_json(cell == nullptr ? Proportion{} : solved_share(*cell, measure));
  }
  return json;
}

}  // namespace

std::vector<ToleranceMap> tolerance_maps(const Summary& summary, const std::vector<Grid>& grids) {
  std::vector<ToleranceMap> maps;
  for (const Grid& grid : grids) {
    std::optional<ToleranceMap> map = map_of(summary, grid);
    if (map) maps.push_back(std::move(*map));
  }
  return maps;
}

Json tolerance_maps_json(const Summary& summary, const std::vector<ToleranceMap>& maps) {
  Json records = Json::array();
  for (const ToleranceMap& map : maps) {
    for (std::size_t zero = 0; zero < map.zero_tolerances.size(); ++zero) {
      for (std::size_t pivot = 0; pivot < map.pivot_tolerances.size(); ++pivot) {
        records.push_back(record(summary.sets[map.grid->set].name, map.grid->label, map.pivot_tolerances[pivot],
                                 map.zero_tolerances[zero], map.at(pivot, zero)));
      }
    }
  }
  return records;
}

Json tolerance_maps_example() { return record("", "", 0, 0, nullptr); }

}  // namespace lcpbench::paper
