#include "study/paper/records.h"

#include <array>
#include <string>

namespace lcpbench::paper {

namespace {

/// What "solved" means in a rate.
struct Measure {
  const char* name;
  std::int64_t Part::*part;
  Spread Part::*time;
  Spread Part::*violation;
};
constexpr std::array kMeasures{
    /// The paper's: claimed solved, violation < 1e-3 m/s, work gain < 1e-3 J; of all trials.
    Measure{"criterion", &Part::criterion, &Part::criterion_time, &Part::criterion_violation},
    /// The same of whatever was returned, claimed or not.
    Measure{"criterion_any", &Part::criterion_any, &Part::criterion_any_time, &Part::criterion_any_violation},
    /// This project's: every condition holds to 1e-4; of the trials that are not proven unsolvable.
    Measure{"verdict", &Part::solved, &Part::solved_time, &Part::violation}};

/// A cell as it counts by one measure: part and of, those of the even and those of the odd trials.
Json shares_of(const Cell& cell, std::size_t place, const Measure& measure) {
  Json json{{"place", place}, {"solved_by", measure.name}, {"odd_trials", cell.halves[1].trials}};
  const auto add = [&](const std::string& prefix, const Part& part) {
    json[prefix + "part"] = part.*measure.part;
    json[prefix + "of"] = measure.part == &Part::solved ? part.solvable() : part.trials;
  };
  add("", cell);
  add("even_", cell.halves[0]);
  add("odd_", cell.halves[1]);
  return json;
}

/// Times and violations of a cell and of its odd trials.
void add_spreads(const Cell& cell, std::size_t place, Json& records) {
  const auto add = [&](const char* quantity, const char* by, Spread Part::*of) {
    const Spread& all = cell.*of;
    const Spread& odd = cell.halves[1].*of;
    records.push_back({{"cell", place},        {"quantity", quantity}, {"by", by},         {"n", all.count},
                       {"mean", all.mean},     {"sigma", all.sigma},   {"max", all.max},   {"odd_n", odd.count},
                       {"odd_mean", odd.mean}, {"odd_sigma", odd.sigma}, {"odd_max", odd.max}});
  };
  for (const Measure& measure : kMeasures) {
    add("time_solved", measure.name, measure.time);
    add("time_all", measure.name, &Part::all_time);
    add("violation", measure.name, measure.violation);
  }
}

}  // namespace

Json paper_records(const Summary& summary) {
  Json counts = Json::array();
  Json spreads = Json::array();
  for (std::size_t place = 0; place < summary.cells.size(); ++place) {
    const Cell& cell = summary.cells[place];
    if (!summary.sets[cell.set].name.starts_with("paper/")) continue;
    for (const Measure& measure : kMeasures) counts.push_back(shares_of(cell, place, measure));
    if (!summary.solvers[cell.solver].sweep.empty()) add_spreads(cell, place, spreads);
  }
  return {{"paper_counts", std::move(counts)}, {"paper_spreads", std::move(spreads)}};
}

}  // namespace lcpbench::paper
