#include "study/paper/records.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/registry.h"
#include "core/spec.h"
#include "study/paper/paper_set.h"

namespace lcpbench::paper {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kPaperSweep = "paper";

/// What "solved" means in a rate, in a cell and in its halves.
struct Measure {
  const char* name;
  Spread Cell::*time;
  Spread Cell::*violation;
  Spread Cell::Half::*half_time;
  Spread Cell::Half::*half_violation;
};
using Half = Cell::Half;
constexpr std::array kMeasures{
    /// The paper's: claimed solved, violation < 1e-3 m/s, work gain < 1e-3 J; of all trials.
    Measure{"criterion", &Cell::criterion_time, &Cell::criterion_violation, &Half::criterion_time,
            &Half::criterion_violation},
    /// The same of whatever was returned, claimed or not.
    Measure{"criterion_any", &Cell::criterion_any_time, &Cell::criterion_any_violation, &Half::criterion_any_time,
            &Half::criterion_any_violation},
    /// This project's: every condition holds to 1e-4; of the trials that are not proven unsolvable.
    Measure{"verdict", &Cell::solved_time, &Cell::violation, &Half::solved_time, &Half::violation}};

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

/// A cell as it counts by one measure: part and of, those of the even and those of the odd trials.
Json shares_of(const Cell& cell, std::size_t measure) {
  Json json = Json::object();
  const auto add = [&](const std::string& prefix, const auto& part, std::int64_t solved) {
    const std::array<std::int64_t, 3> counts{part.criterion, part.criterion_any, solved};
    json[prefix + "part"] = counts[measure];
    json[prefix + "of"] = part.trials - (measure == 2 ? part.unsolvable_problems : 0);
  };
  add("", cell, cell.count(Verdict::kSolved));
  add("even_", cell.halves[0], cell.halves[0].solved);
  add("odd_", cell.halves[1], cell.halves[1].solved);
  return json;
}

/// What a cell is called: its set, its solver, and its sweep with what all cells of that share off their defaults, as
/// "paper{engine=kernel}" has it.
Json cell_head(const Summary& summary, const Cell& cell, const PaperSet& problems) {
  const SolverRow& row = summary.solvers[cell.solver];
  Spec base = row.sweep.empty() ? Spec{row.text(), {}} : spec_or_name(row.sweep);
  const std::string grid = row.sweep.empty() ? "" : std::exchange(base.name, row.name);
  const std::string solver = row.sweep.empty() ? row.text() : base.text();
  Json record = head(problems, summary.sets[cell.set].name, solver);
  record.update({{"label", grid.empty() || grid == kPaperSweep ? solver : solver + " (sweep " + grid + ")"},
                 {"base", solver},
                 {"wrapped", wrapped_solver(solver)},
                 {"rules_2012", follows_rules_2012(solver)},
                 {"grid", grid},
                 {"spec", row.text()},
                 {"name", row.name},
                 {"sweep", row.sweep},
                 {"settings", row.settings.empty() ? "defaults" : row.settings},
                 {"isa", row.isa},
                 {"build", row.library + " " + row.version},
                 {"trials", cell.trials},
                 {"refused", cell.count(Claim::kUnsupported)},
                 {"refusal", cell.refusal},
                 {"unsolvable", cell.unsolvable_problems},
                 {"false_claims", cell.false_claims()},
                 {"odd_solved", cell.halves[1].solved},
                 {"odd_trials", cell.halves[1].trials},
                 {"pivot_tolerance", Json()},
                 {"zero_tolerance", Json()}});
  try {
    const Options options = parse_spec(row.name + "{" + row.all_settings + "}").options;
    for (const char* name : {"pivot_tolerance", "zero_tolerance"}) {
      record[name] = find_number(options, name).value_or(kNoNumber);
    }
  } catch (const InputError&) {  // a store of other hands may spell settings otherwise
  }
  return record;
}

/// Times and violations of a cell and of its odd trials.
void add_spreads(const Cell& cell, std::size_t place, Json& records) {
  const auto add = [&](const char* quantity, const char* by, const Spread& all, const Spread& odd) {
    records.push_back({{"cell", place},        {"quantity", quantity}, {"by", by},         {"n", all.count},
                       {"mean", all.mean},     {"sigma", all.sigma},   {"max", all.max},   {"odd_n", odd.count},
                       {"odd_mean", odd.mean}, {"odd_sigma", odd.sigma}, {"odd_max", odd.max}});
  };
  const Half& odd = cell.halves[1];
  for (const Measure& measure : kMeasures) {
    add("time_solved", measure.name, cell.*measure.time, odd.*measure.half_time);
    add("time_all", measure.name, cell.all_time, odd.all_time);
    add("violation", measure.name, cell.*measure.violation, odd.*measure.half_violation);
  }
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

/// Of the trials that both met and took, by seed and number.
Json pair_by_trial(const Cell& first, const Cell& second) {
  std::map<std::pair<std::int64_t, std::int64_t>, const Outcome*> others;
  for (const Outcome& outcome : second.outcomes) others.emplace(std::pair{outcome.seed, outcome.trial}, &outcome);
  const auto counts = [](const Outcome& outcome) { return !outcome.unsolvable && !outcome.refused; };
  std::int64_t problems = 0;
  std::int64_t only_first = 0;
  std::int64_t only_second = 0;
  for (const Outcome& outcome : first.outcomes) {
    const auto other = others.find({outcome.seed, outcome.trial});
    if (other == others.end() || !counts(outcome) || !counts(*other->second)) continue;
    ++problems;
    only_first += outcome.solved && !other->second->solved ? 1 : 0;
    only_second += !outcome.solved && other->second->solved ? 1 : 0;
  }
  return {{"problems", problems}, {"only_first", only_first}, {"only_second", only_second}};
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
      records.push_back(record);
      records.back()["second"] = other["solver"];
      records.back().update(pair_by_trial(*first, *second));
    }
  }
  return records;
}

}  // namespace

Json paper_records(const Summary& summary) {
  Json cells = Json::array();
  Json counts = Json::array();
  Json spreads = Json::array();
  for (std::size_t place = 0; place < summary.cells.size(); ++place) {
    const Cell& cell = summary.cells[place];
    const std::optional<PaperSet> problems = paper_set(summary.sets[cell.set].name);
    if (!problems) continue;
    cells.push_back(cell_head(summary, cell, *problems));
    cells.back()["place"] = place;
    for (std::size_t measure = 0; measure < kMeasures.size(); ++measure) {
      counts.push_back({{"place", place}, {"solved_by", kMeasures[measure].name}});
      counts.back().update(shares_of(cell, measure));
    }
    if (cells.back()["sweep"] != "") add_spreads(cell, place, spreads);
  }
  return {{"published", published_records()},
          {"paper_cells", std::move(cells)},
          {"paper_counts", std::move(counts)},
          {"paper_spreads", std::move(spreads)},
          {"paper_pairs", pair_records(summary)}};
}

}  // namespace lcpbench::paper
