#include "study/report/speed_error.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <regex>
#include <string>

#include <fmt/format.h>

#include "core/error.h"
#include "core/spec.h"
#include "study/report/figures.h"
#include "study/report/hard.h"
#include "study/report/solver_comparison.h"
#include "study/report/tables.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

using Json = nlohmann::ordered_json;

/// NaN: not known. Infinity: the answer is no number.
double error_of(const Outcome& outcome, ErrorMeasure measure) {
  if (measure == ErrorMeasure::kForward) return outcome.forward_error;
  return std::isnan(outcome.error) ? kInfinity : outcome.error;
}

SpeedErrorPoint make_point(const Cell& cell, ErrorMeasure measure, bool relative, const Reliability& reliability) {
  SpeedErrorPoint point;
  point.cell = &cell;
  point.cost = relative ? cell.time_ratio : cell.median_time;
  point.reliability = reliability;
  std::vector<double> errors;
  for (const Outcome& outcome : cell.outcomes) {
    if (!outcome.claimed) continue;
    ++point.answers;
    const double error = error_of(outcome, measure);
    if (!std::isnan(error)) errors.push_back(error);
  }
  std::sort(errors.begin(), errors.end());
  point.known = static_cast<std::int64_t>(errors.size());
  point.median = median(errors);
  point.p99 = quantile(errors, 0.99);
  return point;
}

/// Is `a` a reason not to choose `b`?
bool dominates(const SpeedErrorPoint& a, const SpeedErrorPoint& b) {
  const bool no_worse = a.cost.value <= b.cost.value && a.p99 <= b.p99;
  return no_worse && (a.cost.value < b.cost.value || a.p99 < b.p99);
}

bool selectable(const SpeedErrorPoint& point) { return point.reliable() && point.placed() && std::isfinite(point.p99); }

void mark_frontier(std::vector<SpeedErrorPoint>& points) {
  for (SpeedErrorPoint& point : points) {
    point.frontier = selectable(point) && std::none_of(points.begin(), points.end(), [&](const auto& other) {
                       return selectable(other) && dominates(other, point);
                     });
  }
}

std::optional<std::size_t> cheapest_within(const std::vector<SpeedErrorPoint>& points, double target,
                                           double SpeedErrorPoint::*error) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!selectable(points[i]) || !(points[i].*error <= target)) continue;
    if (!best || points[i].cost.value < points[*best].cost.value) best = i;
  }
  return best;
}

/// Did the reference solve a problem of the set that some solver solved too?
bool has_ratios(const std::vector<const Cell*>& cells) {
  return std::any_of(cells.begin(), cells.end(), [](const Cell* cell) { return !std::isnan(cell->time_ratio.value); });
}

std::optional<Spec> spec_of(const std::string& set) {
  try {
    return parse_spec(set);
  } catch (const InputError&) {
    return std::nullopt;  // the name of a file
  }
}

std::optional<double> condition_number(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  const bool whole = end == text.c_str() + text.size() && !text.empty();
  return whole && std::isfinite(value) && value >= 1 ? std::optional(value) : std::nullopt;
}

/// A set of the store and where it stands in its family.
struct Member {
  double condition = 0;
  std::size_t set = 0;
};

/// The weakest of the members' measures: all have it, and no two measures meet in one family.
ErrorMeasure common_measure(const Summary& summary, const std::vector<Member>& members) {
  const bool all_forward = std::all_of(members.begin(), members.end(), [&](const Member& member) {
    return best_measure(summary.sets[member.set]) == ErrorMeasure::kForward;
  });
  return all_forward ? ErrorMeasure::kForward : ErrorMeasure::kResidual;
}

std::vector<std::size_t> recurring_solvers(const std::vector<SpeedError>& steps) {
  std::map<std::size_t, int> seen;
  for (const SpeedError& step : steps) {
    for (const SpeedErrorPoint& point : step.points) {
      if (point.placed()) ++seen[point.cell->solver];
    }
  }
  std::vector<std::size_t> solvers;
  for (const auto& [solver, times] : seen) {
    if (times >= 2) solvers.push_back(solver);
  }
  return solvers;
}

Conditioning make_family(const Summary& summary, const std::string& name, std::vector<Member> members) {
  std::sort(members.begin(), members.end(), [](const Member& a, const Member& b) { return a.condition < b.condition; });
  Conditioning family;
  family.family = name;
  family.measure = common_measure(summary, members);
  for (const Member& member : members) {
    family.conditions.push_back(member.condition);
    family.steps.push_back(speed_error(summary, member.set, family.measure));
  }
  const bool relative =
      std::all_of(family.steps.begin(), family.steps.end(), [](const SpeedError& step) { return step.relative; });
  if (!relative) {
    for (SpeedError& step : family.steps) step = speed_error(summary, step.set, family.measure, false);
  }
  family.solvers = recurring_solvers(family.steps);
  return family;
}

}  // namespace

const char* to_string(ErrorMeasure measure) {
  switch (measure) {
    case ErrorMeasure::kNone: return "";
    case ErrorMeasure::kForward: return "forward_velocity";
    case ErrorMeasure::kResidual: return "velocity_residual_relative";
    case ErrorMeasure::kBackward: return "backward_row_norm";
  }
  return "";
}

std::string measure_words(ErrorMeasure measure) {
  switch (measure) {
    case ErrorMeasure::kNone: return "no one error";
    case ErrorMeasure::kForward: return "true error of the velocity, relative, against the certified one";
    case ErrorMeasure::kResidual: return "error ρ, relative velocity residual";
    case ErrorMeasure::kBackward: return "backward error";
  }
  return "";
}

ErrorMeasure best_measure(const SetSummary& set) {
  if (set.bare) return ErrorMeasure::kBackward;
  if (!set.contact) return ErrorMeasure::kNone;
  const bool certified = set.unique_velocities > 0 && 2 * set.unique_velocities >= set.problems;
  return certified ? ErrorMeasure::kForward : ErrorMeasure::kResidual;
}

bool SpeedErrorPoint::placed() const { return std::isfinite(cost.value) && cost.value > 0 && !std::isnan(p99); }

bool SpeedErrorPoint::failed() const {
  const std::int64_t taken = cell->solvable() - cell->count(Verdict::kRefused);
  const auto solved = static_cast<double>(cell->count(Verdict::kSolved));
  return std::isinf(p99) || solved < kReliableShare * static_cast<double>(taken);
}

SpeedError speed_error(const Summary& summary, std::size_t set, std::optional<ErrorMeasure> measure, bool ratios) {
  SpeedError result;
  result.set = set;
  result.measure = measure.value_or(best_measure(summary.sets[set]));
  if (result.measure == ErrorMeasure::kNone) return result;
  const std::vector<const Cell*> cells = drawn_cells(summary, set);
  result.relative = ratios && has_ratios(cells);
  result.plan_share = plan_share(summary, {set});
  std::map<std::size_t, Reliability> reliability;
  for (const Record& record : judged_records(summary, {set})) {
    reliability[record.solver] = record.reliability;
    result.most_problems = std::max(result.most_problems, record.evidence.solved.whole);
  }
  for (const Cell* cell : cells) {
    result.points.push_back(make_point(*cell, result.measure, result.relative, reliability.at(cell->solver)));
  }
  mark_frontier(result.points);
  for (const double target : kErrorTargets) {
    result.cheapest.push_back({target, cheapest_within(result.points, target, &SpeedErrorPoint::median),
                               cheapest_within(result.points, target, &SpeedErrorPoint::p99)});
  }
  return result;
}

std::vector<SpeedError> speed_errors(const Summary& summary) {
  std::vector<SpeedError> sets;
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    if (is_hard_set(summary.sets[set].name)) continue;
    SpeedError result = speed_error(summary, set);
    if (!result.points.empty()) sets.push_back(std::move(result));
  }
  return sets;
}

Json point_json(const Summary& summary, const SpeedError& set, const SpeedErrorPoint& point) {
  const SolverRow& solver = summary.solvers[point.cell->solver];
  return {{"solver", solver.name},
          {"settings", solver.settings},
          {"isa", solver.isa},
          {"measure", to_string(set.measure)},
          {"trials", point.cell->trials},
          {"solved", point.cell->count(Verdict::kSolved)},
          {"false_claims", point.cell->false_claims()},
          {"gave_up", point.cell->gave_up()},
          {"answers", point.answers},
          {"known", point.known},
          {"error", {{"median", point.median}, {"p99", point.p99}}},
          {"time_ratio", estimate_json(point.cell->time_ratio)},
          {"median_time_s", point.cell->median_time.value},
          {"reliable", reliable_json(point.reliability)},
          {"frontier", point.frontier},
          {"reliability", to_string(point.reliability.ground)}};
}

Json speed_error_json(const Summary& summary, const std::vector<SpeedError>& sets) {
  Json records = Json::array();
  for (const SpeedError& set : sets) {
    for (const SpeedErrorPoint& point : set.points) {
      Json record{{"set", summary.sets[set.set].name}};
      record.update(point_json(summary, set, point));
      records.push_back(std::move(record));
    }
  }
  return records;
}

Json cheapest_json(const Summary& summary, const std::vector<SpeedError>& sets) {
  Json records = Json::array();
  for (const SpeedError& set : sets) {
    for (const Cheapest& cheapest : set.cheapest) {
      for (const bool by_p99 : {false, true}) {
        const std::optional<std::size_t> place = by_p99 ? cheapest.by_p99 : cheapest.by_median;
        const SpeedErrorPoint* point = place ? &set.points[*place] : nullptr;
        Json record{{"set", summary.sets[set.set].name},
                    {"measure", to_string(set.measure)},
                    {"statistic", by_p99 ? "p99" : "median"},
                    {"target", cheapest.target},
                    {"solver", Json()},
                    {"settings", Json()},
                    {"error", Json()},
                    {"time_ratio", {{"value", Json()}, {"low", Json()}, {"high", Json()}}},
                    {"median_time_s", Json()}};
        if (point != nullptr) {
          const SolverRow& solver = summary.solvers[point->cell->solver];
          record["solver"] = solver.name;
          record["settings"] = solver.settings;
          record["error"] = by_p99 ? point->p99 : point->median;
          record["time_ratio"] = estimate_json(point->cell->time_ratio);
          record["median_time_s"] = point->cell->median_time.value;
        }
        records.push_back(std::move(record));
      }
    }
  }
  return records;
}

std::string cost_text(const SpeedError& set, const SpeedErrorPoint& point) {
  return set.relative ? over_reference(*point.cell).text() : duration(point.cost.value);
}

std::string rung_label(const Summary& summary, std::size_t solver) {
  static constexpr std::string_view kRung = "precision=";
  const SolverRow& row = summary.solvers[solver];
  const std::string label = solver_label(summary, solver);
  const bool rung_alone = row.settings.starts_with(kRung) && row.settings.find(',') == std::string::npos;
  return rung_alone && label == row.text() ? row.name + " " + row.settings.substr(kRung.size()) : label;
}

std::optional<ConditionDial> condition_dial(const std::string& set) {
  const std::optional<Spec> spec = spec_of(set);
  if (!spec || !(spec->name.starts_with("paper/") || spec->name.starts_with("rigid/"))) return std::nullopt;
  Spec family = *spec;
  for (auto& [key, value] : family.options) {
    if (key != "condition") continue;
    const std::optional<double> condition = condition_number(value);
    if (!condition) return std::nullopt;
    value = "*";
    return ConditionDial{family.text(), *condition, true};
  }
  std::smatch match;
  static const std::regex conditioned("(.*/exp[56]-)(1e[0-9]+)");
  if (!std::regex_match(spec->name, match, conditioned)) return std::nullopt;
  const std::optional<double> condition = condition_number(match[2].str());
  if (!condition) return std::nullopt;
  family.name = match[1].str() + "*";
  return ConditionDial{family.text(), *condition, false};
}

std::string condition_text(double condition) {
  static const std::regex padding("e\\+0*");
  const double exponent = std::log10(condition);
  if (exponent == std::round(exponent)) return fmt::format("1e{:.0f}", exponent);
  return std::regex_replace(fmt::format("{:g}", condition), padding, "e");
}

std::vector<Conditioning> conditioning(const Summary& summary) {
  std::vector<std::string> names;
  std::map<std::string, std::vector<Member>> families;
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    const std::optional<ConditionDial> dial = condition_dial(summary.sets[set].name);
    if (!dial || !summary.sets[set].contact || drawn_cells(summary, set).empty()) continue;
    std::vector<Member>& members = families[dial->family];
    if (members.empty()) names.push_back(dial->family);
    members.push_back({dial->condition, set});
  }
  std::vector<Conditioning> result;
  for (const std::string& name : names) {
    if (families[name].size() >= 2) result.push_back(make_family(summary, name, families[name]));
  }
  return result;
}

bool SpeedErrorStudy::is_step(const Summary& summary, std::size_t set) const {
  const std::optional<ConditionDial> dial = condition_dial(summary.sets[set].name);
  return dial && dial->by_option && std::any_of(families.begin(), families.end(), [&](const Conditioning& family) {
           return family.family == dial->family;
         });
}

SpeedErrorStudy speed_error_study(const Summary& summary) { return {speed_errors(summary), conditioning(summary)}; }

Json conditioning_json(const Summary& summary, const std::vector<Conditioning>& families) {
  Json records = Json::array();
  for (const Conditioning& family : families) {
    for (std::size_t i = 0; i < family.steps.size(); ++i) {
      for (const SpeedErrorPoint& point : family.steps[i].points) {
        Json record{{"family", family.family}, {"condition", family.conditions[i]}};
        record.update(point_json(summary, family.steps[i], point));
        records.push_back(std::move(record));
      }
    }
  }
  return records;
}

}  // namespace lcpbench::report
