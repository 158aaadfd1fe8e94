#include "study/report/speed_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "study/report/solver_comparison.h"
#include "study/report/figures.h"
#include "study/report/hard.h"

namespace lcpbench::report {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

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

Json estimate_json(const Estimate& estimate) {
  return {{"value", estimate.value}, {"low", estimate.low}, {"high", estimate.high}};
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

std::string rung_label(const Summary& summary, std::size_t solver) {
  static constexpr std::string_view kRung = "precision=";
  const SolverRow& row = summary.solvers[solver];
  const std::string label = solver_label(summary, solver);
  const bool rung_alone = row.settings.starts_with(kRung) && row.settings.find(',') == std::string::npos;
  return rung_alone && label == row.text() ? row.name + " " + row.settings.substr(kRung.size()) : label;
}

}  // namespace lcpbench::report
