#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "core/error.h"
#include "core/registry.h"
#include "study/paper/tables.h"

namespace lcpbench::paper {

namespace {

using Json = nlohmann::ordered_json;

std::string triple(double worst, double average, double best) {
  return points(worst) + " / " + points(average) + " / " + points(best);
}

Entry published_entry(Kind kind, const Experiment& experiment, Family family) {
  const std::optional<PublishedRate> rate = published_rate(kind, experiment.name, family);
  return rate ? Entry{triple(rate->worst, rate->average, rate->best), ""} : Entry{kAbsent, ""};
}

/// What PATH was measured to do apart from the store, where its own column would be empty.
std::optional<PathMeasured> measured_apart(Kind kind, const Experiment& experiment, const std::string& reading,
                                           const Contestant& contestant) {
  const bool is_absent_path = contestant.label.empty() && contestant.family == Family::kPath;
  return is_absent_path && reading == kReadings.front() ? path_measured(kind, experiment.name) : std::nullopt;
}

Entry apart_entry(const PathMeasured& path, Measure measure, const std::string& why_not_run) {
  const std::string detail = "measured separately, 4.7.03" + (why_not_run.empty() ? "" : "; " + why_not_run);
  if (measure == Measure::kVerdict) return {kAbsent, detail};
  const ShareRange& range = measure == Measure::kCriterion ? path.claimed : path.any;
  return {triple(range.worst, range.average, range.best), detail};
}

Entry range_entry(const GridRange& range) {
  if (range.best_cell == nullptr) return {kAbsent, "no problem is known to be solvable"};
  return {triple(range.worst.value(), range.average.value(), range.best.value()),
          fmt::format("worst {}; best {}; n = {:.0f}", points(range.worst.interval()), points(range.best.interval()),
                      range.average.trials)};
}

/// A column of the rates: what the paper prints of a solver, or one of ours.
struct RateColumn {
  Contestant contestant;
  bool published = false;
};

/// Before the first of ours of each of the paper's solvers stands what the paper prints of it.
std::vector<RateColumn> rate_columns(const std::vector<Contestant>& contestants, Kind kind) {
  std::vector<RateColumn> columns;
  std::optional<Family> last;
  for (const Contestant& contestant : contestants) {
    const bool printed = contestant.family && published_rate(kind, "exp1", *contestant.family);
    if (printed && contestant.family != last) columns.push_back({contestant, true});
    if (printed) last = contestant.family;
    columns.push_back({contestant, false});
  }
  return columns;
}

std::string column_title(const RateColumn& column) {
  if (column.published) return std::string(name_of(*column.contestant.family)) + ", published";
  if (column.contestant.label.empty()) return std::string(name_of(*column.contestant.family)) + ", ours";
  return code(column.contestant.label);
}

/// Worst / average / best: per experiment and reading one row for each measure, or one that says that nothing was run;
/// a column per solver.
class RatesLayout {
 public:
  RatesLayout(const Summary& summary, const std::vector<Grid>& grids, Kind kind, const Picks& picks)
      : summary_(summary),
        grids_(grids),
        kind_(kind),
        columns_(rate_columns(contestants(grids, kind, picks, published_families(kind)), kind)) {}

  Layout build(const std::string& caption, const Picks& picks) {
    layout_ = {caption, {"Experiment", "Redundancy", "Solved by"}, 3, {}};
    for (const RateColumn& column : columns_) layout_.columns.push_back(column_title(column));
    for (const Experiment& experiment : experiments()) {
      if (picks(experiment)) add_experiment(experiment);
    }
    return std::move(layout_);
  }

 private:
  void add_experiment(const Experiment& experiment) {
    bool first = true;
    for (const std::string& reading : readings_of(experiment)) {
      std::vector<std::optional<Measure>> measures{kCounts.begin(), kCounts.end()};
      if (!was_run(experiment, reading)) measures = {std::nullopt};
      for (const std::optional<Measure> measure : measures)
        add_row(experiment, reading, measure, std::exchange(first, false));
    }
  }

  bool was_run(const Experiment& experiment, const std::string& reading) const {
    return std::any_of(columns_.begin(), columns_.end(), [&](const RateColumn& column) {
      return find_grid(grids_, kind_, experiment, reading, column.contestant.label) != nullptr;
    });
  }

  void add_row(const Experiment& experiment, const std::string& reading, std::optional<Measure> measure,
               bool with_published) {
    std::vector<Entry> row{{std::string(experiment.title), ""},
                           {reading_words(experiment, reading), ""},
                           {measure ? words_for(*measure) : kAbsent, ""}};
    for (const RateColumn& column : columns_) {
      if (column.published) {
        row.push_back(with_published ? published_entry(kind_, experiment, *column.contestant.family) : Entry{});
        continue;
      }
      const Grid* grid = find_grid(grids_, kind_, experiment, reading, column.contestant.label);
      if (grid == nullptr || !measure) {
        const auto path = measured_apart(kind_, experiment, reading, column.contestant);
        const Entry why = not_run(column.contestant);
        const bool first = layout_.rows.empty();
        row.push_back(path && measure ? apart_entry(*path, *measure, first ? why.text : "") : why);
      } else {
        row.push_back(grid->refused() > 0 ? refused_entry(*grid) : range_entry(range_of(*grid, *measure)));
      }
    }
    layout_.rows.push_back(std::move(row));
  }

  /// The reason stands once, in the table's first row.
  Entry not_run(const Contestant& contestant) const {
    const bool explain = contestant.label.empty() && layout_.rows.empty();
    return {explain ? why_not_run(summary_, *contestant.family) : "not run", ""};
  }

  const Summary& summary_;
  const std::vector<Grid>& grids_;
  Kind kind_;
  std::vector<RateColumn> columns_;
  Layout layout_;
};

Layout rates_layout(const Summary& summary, const std::vector<Grid>& grids, Kind kind, const std::string& caption,
                    const Picks& picks) {
  return RatesLayout(summary, grids, kind, picks).build(caption, picks);
}

/// A row for each grid and measure: what it is, then entries_of(grid, range); none where that gives none.
template <class EntriesOf>
Layout grids_layout(const std::vector<Grid>& grids, Kind kind, Layout layout, EntriesOf entries_of) {
  for (const Grid& grid : grids) {
    if (!compared_with_paper(grid, kind) || grid.refused() > 0) continue;
    const Experiment& experiment = *grid.problems.experiment;
    for (const Measure measure : kCounts) {
      std::vector<Entry> row{{std::string(experiment.title), ""},
                             {reading_words(experiment, grid.problems.redundancy()), ""},
                             {code(grid.label), ""},
                             {words_for(measure), ""}};
      const std::vector<Entry> entries = entries_of(grid, range_of(grid, measure));
      row.insert(row.end(), entries.begin(), entries.end());
      if (!entries.empty()) layout.rows.push_back(std::move(row));
    }
  }
  return layout;
}

/// The parameterisation that the even trials choose, and what it does on the odd ones.
Layout chosen_layout(const Summary& summary, const std::vector<Grid>& grids, Kind kind) {
  return grids_layout(
      grids, kind,
      {"Best parameterisation: chosen on the even trials, its rate on the odd ones",
       {"Experiment", "Redundancy", "Solver", "Solved by", "Parameterisation", "Even trials", "Odd trials"},
       5,
       {}},
      [&summary](const Grid&, const GridRange& range) -> std::vector<Entry> {
        if (range.chosen == nullptr) return {};
        return {{code(settings_of(summary, range.chosen)), ""},
                {points(range.chosen_even.value()), ""},
                {points(range.held_out.value()), points(range.held_out.interval())}};
      });
}

/// How far a solver's rate depends on its parameters.
Layout robustness_layout(const std::vector<Grid>& grids, Kind kind) {
  return grids_layout(
      grids, kind,
      {"Dependence on the parameters: range (best − worst) and standard deviation of the rates [points]",
       {"Experiment", "Redundancy", "Solver", "Solved by", "Parameterisations", "Range", "Sigma"},
       4,
       {}},
      [](const Grid& grid, const GridRange& range) -> std::vector<Entry> {
        if (range.best_cell == nullptr) return {};
        return {{std::to_string(grid.cells.size()), ""},
                {points(range.best.value() - range.worst.value()), ""},
                {points(range.sigma), ""}};
      });
}

Json range_json(const Summary& summary, const GridRange& range) {
  return {{"worst", share_json(range.worst)},
          {"average", range.average.value()},
          {"best", share_json(range.best)},
          {"sigma", range.sigma},
          {"worst_settings", settings_of(summary, range.worst_cell)},
          {"best_settings", settings_of(summary, range.best_cell)},
          {"chosen_on_even", settings_of(summary, range.chosen)},
          {"even", range.chosen_even.value()},
          {"held_out", share_json(range.held_out)}};
}

Json rates_record(const Summary& summary, const std::string& table, Kind kind, const Experiment& experiment,
                  const std::string& reading, const Contestant& contestant, const Grid* grid) {
  const std::optional<PublishedRate> published =
      contestant.family ? published_rate(kind, experiment.name, *contestant.family) : std::nullopt;
  const double none = Proportion{}.value();
  Json record{{"table", table},
              {"kind", name_of(kind)},
              {"experiment", experiment.name},
              {"redundancy", reading_words(experiment, reading)},
              {"paper_solver", contestant.family ? name_of(*contestant.family) : ""},
              {"solver", contestant.label},
              {"set", grid == nullptr ? "" : summary.sets[grid->set].name},
              {"not_run", why_no_numbers(summary, contestant, grid)},
              {"parameterisations", grid == nullptr ? 0 : grid->cells.size()}};
  record["trials"] = grid == nullptr ? none : range_of(*grid, Measure::kCriterion).average.trials;
  record["published"] = {{"worst", published ? published->worst : none},
                         {"average", published ? published->average : none},
                         {"best", published ? published->best : none}};
  const std::optional<PathMeasured> path = measured_apart(kind, experiment, reading, contestant);
  const auto range_of_path = [none](const ShareRange* range) {
    return Json{{"worst", range == nullptr ? none : range->worst},
                {"average", range == nullptr ? none : range->average},
                {"best", range == nullptr ? none : range->best}};
  };
  record["measured_apart"] = {{"criterion", range_of_path(path ? &path->claimed : nullptr)},
                              {"criterion_any", range_of_path(path ? &path->any : nullptr)}};
  for (const Measure measure : kCounts) {
    record[name_of(measure)] = range_json(summary, grid == nullptr ? GridRange{} : range_of(*grid, measure));
  }
  return record;
}

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

Table rates_table(const Summary& summary, const std::vector<Grid>& grids, Kind kind) {
  Table table;
  table.id = kind == Kind::kMonotone ? "IV.1" : "IV.2";
  table.title = std::string("Solution frequency, ") + name_of(kind) + " problems [%]";
  const auto plain = [](const Experiment& experiment) { return !experiment.regularized; };
  table.layouts = {
      rates_layout(summary, grids, kind, "Worst / average / best over the parameters. Experiments 1 to 5", plain),
      rates_layout(summary, grids, kind, "Worst / average / best over the parameters. Experiment 6, regularised",
                   is_experiment_six),
      chosen_layout(summary, grids, kind), robustness_layout(grids, kind)};
  table.notes = {
      kSolvedNote,
      "Small numbers: Wilson 95 % intervals of the shares of the worst and of the best cell, and the trials of each "
      "cell. They hold for a cell named beforehand. The best of many cells flatters and the worst belittles, so the "
      "third table chooses the best on the even trials and gives its interval on the odd ones, where no choice was "
      "made.",
      "In Experiment 6 the paper’s Lemke is `regularized{test=tried}`, whose test of an answer is the published one; "
      "`regularized` tests the answer on the problem itself. Redundancy: `multiple`, a redundant contact is a multiple "
      "of one other; `combination`, of all independent ones (`docs/reference/generators.md`)."};
  if (kind == Kind::kMonotone) {
    table.notes.push_back(
        "“Measured apart”: PATH 4.7.03 through the adapter `path`, 2,000 trials of seed 1, redundancy `multiple`; not "
        "of this store. Whoever has the library fills the column with `lcpbench run paper` "
        "(`docs/reference/solvers/path.md`).");
  }
  table.query = rates_query(kind);
  table.records = Json::array();
  for (const Experiment& experiment : experiments()) {
    const Picks same_part = [&experiment](const Experiment& other) {
      return other.regularized == experiment.regularized;
    };
    for (const Contestant& contestant : contestants(grids, kind, same_part, published_families(kind))) {
      for (const std::string& reading : readings_of(experiment)) {
        const Grid* grid = find_grid(grids, kind, experiment, reading, contestant.label);
        table.records.push_back(rates_record(summary, table.id, kind, experiment, reading, contestant, grid));
      }
    }
  }
  table.example = rates_record(summary, "", kind, experiments().front(), "", {Family::kLemke, ""}, nullptr);
  return table;
}

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
