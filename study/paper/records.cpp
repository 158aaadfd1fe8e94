#include "study/paper/records.h"

#include <array>
#include <string>

namespace lcpbench::paper {

namespace {

using Json = nlohmann::ordered_json;
using Half = Cell::Half;

/// What "solved" means in a rate, in a cell and in its halves.
struct Measure {
  const char* name;
  Spread Cell::*time;
  Spread Cell::*violation;
  Spread Half::*half_time;
  Spread Half::*half_violation;
};
constexpr std::array kMeasures{
    /// The paper's: claimed solved, violation < 1e-3 m/s, work gain < 1e-3 J; of all trials.
    Measure{"criterion", &Cell::criterion_time, &Cell::criterion_violation, &Half::criterion_time,
            &Half::criterion_violation},
    /// The same of whatever was returned, claimed or not.
    Measure{"criterion_any", &Cell::criterion_any_time, &Cell::criterion_any_violation, &Half::criterion_any_time,
            &Half::criterion_any_violation},
    /// This project's: every condition holds to 1e-4; of the trials that are not proven unsolvable.
    Measure{"verdict", &Cell::solved_time, &Cell::violation, &Half::solved_time, &Half::violation}};

/// A cell as it counts by one measure: part and of, those of the even and those of the odd trials.
Json shares_of(const Cell& cell, std::size_t place, std::size_t measure) {
  Json json{{"place", place}, {"solved_by", kMeasures[measure].name}, {"odd_trials", cell.halves[1].trials}};
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

}  // namespace

Json paper_records(const Summary& summary) {
  Json counts = Json::array();
  Json spreads = Json::array();
  for (std::size_t place = 0; place < summary.cells.size(); ++place) {
    const Cell& cell = summary.cells[place];
    if (!summary.sets[cell.set].name.starts_with("paper/")) continue;
    for (std::size_t measure = 0; measure < kMeasures.size(); ++measure) {
      counts.push_back(shares_of(cell, place, measure));
    }
    if (!summary.solvers[cell.solver].sweep.empty()) add_spreads(cell, place, spreads);
  }
  return {{"paper_counts", std::move(counts)}, {"paper_spreads", std::move(spreads)}};
}

}  // namespace lcpbench::paper
