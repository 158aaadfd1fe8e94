#include "study/paper/claim_tests.h"

#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace lcpbench::paper::claim_tests {
namespace {

/// Whether what is compared are solvers rather than instruction-set levels; libraries have none.
bool same_level(const SolverRow& a, const SolverRow& b) { return a.isa.empty() || b.isa.empty() || a.isa == b.isa; }

}  // namespace

const Experiment& experiment(std::string_view name) { return *find_experiment(name); }

std::string scope_of(const std::string& reading, Measure measure) {
  return reading + ", " + (measure == Measure::kCriterion ? "criterion" : "verdict");
}

std::string place(Kind kind, const Experiment& where) {
  return std::string(name_of(kind)) + " " + std::string(where.name);
}

Comparison compare(std::string what, std::string scope, const LinearCombination& quantity, double bound, bool above) {
  return {.what = std::move(what),
          .scope = std::move(scope),
          .value = quantity.value(),
          .bound = bound,
          .above = above,
          .interval = [quantity](double z) { return quantity.interval(z); }};
}

Comparison compare(std::string what, std::string scope, const RatioOfMeans& ratio, double bound, bool above) {
  return {.what = std::move(what),
          .scope = std::move(scope),
          .value = ratio.value(),
          .bound = bound,
          .above = above,
          .share = false,
          .interval = [ratio](double z) { return ratio.interval(z); }};
}

Comparison shown(std::string what, std::string scope, double value, double bound, bool above) {
  return {.what = std::move(what),
          .scope = std::move(scope),
          .value = value,
          .bound = bound,
          .above = above,
          .share = false,
          .detail = "no estimate: it has no interval, and is not tested"};
}

Comparison compare(std::string what, std::string scope, const PairedCounts& pairs, double bound, bool above) {
  return {.what = std::move(what),
          .scope = std::move(scope),
          .value = pairs.difference(),
          .bound = bound,
          .above = above,
          .interval = [pairs](double z) { return pairs.interval(z); },
          .p_value = pairs.p_value(),
          .detail = fmt::format("{} problems in pairs, {} only the first, {} only the second; McNemar p = {:.2g}",
                                pairs.problems(), pairs.first_only, pairs.second_only, pairs.p_value())};
}

std::vector<std::string> labels(const Study& study, Kind kind, bool of_the_paper) {
  std::set<std::string> found;
  for (const Grid& grid : study.grids) {
    const bool in_paper = family_of(grid.solver).has_value();
    if (grid.problems.kind == kind && grid.problems.other_readings().empty() && in_paper == of_the_paper) {
      found.insert(grid.label);
    }
  }
  return {found.begin(), found.end()};
}

std::vector<std::string> labels_of(const Study& study, Kind kind, Family family) {
  std::set<std::string> found;
  for (const Grid& grid : study.grids) {
    if (grid.problems.kind == kind && grid.problems.other_readings().empty() && family_of(grid.solver) == family) {
      found.insert(grid.label);
    }
  }
  return {found.begin(), found.end()};
}

const Grid* grid_of(const Study& study, Kind kind, std::string_view where, const std::string& reading,
                    const std::string& label) {
  return find_grid(study.grids, kind, experiment(where), reading, label);
}

const Cell* single_cell(const Study& study, const std::string& set, const std::string& solver,
                        const SolverRow& partner) {
  for (const Cell& cell : study.summary.cells) {
    const SolverRow& row = study.summary.solvers[cell.solver];
    const bool fits = row.sweep.empty() && row.text() == solver && same_level(row, partner);
    if (fits && study.summary.sets[cell.set].name == set && !cell.refused()) return &cell;
  }
  return nullptr;
}

PairedCounts pair_by_trial(const Cell& first, const Cell& second) {
  std::map<std::pair<std::int64_t, std::int64_t>, const Outcome*> others;
  for (const Outcome& outcome : second.outcomes) others.emplace(std::pair{outcome.seed, outcome.trial}, &outcome);
  const auto counts = [](const Outcome& outcome) { return !outcome.unsolvable && !outcome.refused; };
  PairedCounts pairs;
  for (const Outcome& outcome : first.outcomes) {
    const auto other = others.find({outcome.seed, outcome.trial});
    if (other == others.end() || !counts(outcome) || !counts(*other->second)) continue;
    const bool also = other->second->solved;
    ++(outcome.solved ? (also ? pairs.both : pairs.first_only) : (also ? pairs.second_only : pairs.neither));
  }
  return pairs;
}

std::string set_name(Kind kind, const Experiment& where, const std::string& reading) {
  std::string name = std::string("paper/") + name_of(kind) + "/" + std::string(where.name);
  if (where.redundant && reading != kReadings.front()) name += "{redundancy=" + reading + "}";
  return name;
}

}  // namespace lcpbench::paper::claim_tests
