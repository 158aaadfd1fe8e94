#include "study/paper/grids.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <regex>
#include <set>
#include <tuple>

#include "core/error.h"

namespace lcpbench::paper {

namespace {

constexpr std::string_view kPaperSweep = "paper";
constexpr std::string_view kRedundancy = "redundancy";
constexpr std::string_view kRegularized = "regularized";
constexpr const char* kDefaultWrapped = "lemke";  // what `regularized` wraps unless its setting `solver` says otherwise

/// The value of an option, nullptr when it is not given.
const std::string* find_option(const Options& options, std::string_view key) {
  const auto found =
      std::find_if(options.begin(), options.end(), [key](const auto& option) { return option.first == key; });
  return found == options.end() ? nullptr : &found->second;
}

/// The spec that a stored text stands for; a text that is none is taken as a bare name.
Spec spec_or_name(const std::string& text) {
  try {
    return parse_spec(text);
  } catch (const InputError&) {
    return {text, {}};
  }
}

/// What a swept solver is called: its sweep is "paper{engine=kernel}" where all cells have engine=kernel.
std::pair<std::string, std::string> solver_and_sweep(const SolverRow& solver) {
  Spec label = spec_or_name(solver.sweep);
  std::string sweep = label.name;
  label.name = solver.name;
  return {label.text(), std::move(sweep)};
}

/// @param part  a cell or one of its halves
template <class Part>
const Spread& spread_of(const Part& part, Quantity quantity, Measure measure) {
  if (quantity == Quantity::kTimeAll) return part.all_time;
  const bool time = quantity == Quantity::kTimeSolved;
  switch (measure) {
    case Measure::kCriterion: return time ? part.criterion_time : part.criterion_violation;
    case Measure::kCriterionAny: return time ? part.criterion_any_time : part.criterion_any_violation;
    case Measure::kVerdict: break;
  }
  return time ? part.solved_time : part.violation;
}

std::int64_t solved(const Cell& cell) { return cell.count(Verdict::kSolved); }
std::int64_t solved(const Cell::Half& half) { return half.solved; }

/// @param part  a cell or one of its halves
template <class Part>
Proportion share_of(const Part& part, Measure measure) {
  const auto trials = static_cast<double>(part.trials);
  if (measure == Measure::kCriterion) return {static_cast<double>(part.criterion), trials};
  if (measure == Measure::kCriterionAny) return {static_cast<double>(part.criterion_any), trials};
  return {static_cast<double>(solved(part)), static_cast<double>(part.trials - part.unsolvable_problems)};
}

/// The cell with the largest share on the even trials (or the smallest); the first of equals.
const Cell* choose(const Grid& grid, Measure measure, bool largest = true) {
  const Cell* chosen = nullptr;
  double extreme = -kInfinity;
  for (const Cell* cell : grid.cells) {
    const double share = (largest ? 1 : -1) * share_of(cell->halves[0], measure).value();
    if (!(share > extreme)) continue;
    extreme = share;
    chosen = cell;
  }
  return chosen;
}

/// Adds the instruction-set level to labels that the store has at several, and likewise library and version.
void tell_builds_apart(std::vector<Grid>& grids) {
  std::map<std::string, std::set<std::string>> levels;
  std::map<std::string, std::set<std::string>> builds;
  for (const Grid& grid : grids) {
    levels[grid.label].insert(grid.isa);
    builds[grid.label].insert(grid.build);
  }
  for (Grid& grid : grids) {
    const std::string plain = grid.label;
    if (levels[plain].size() > 1) grid.label += " at " + grid.isa;
    if (builds[plain].size() > 1) grid.label += " of " + grid.build;
  }
}

}  // namespace

std::int64_t Grid::refused() const {
  std::int64_t most = 0;
  for (const Cell* cell : cells) most = std::max(most, cell->count(Claim::kUnsupported));
  return most;
}

std::string Grid::refusal() const {
  const std::int64_t most = refused();
  if (most == 0) return "";
  const Cell* cell = *std::find_if(cells.begin(), cells.end(), [most](const Cell* each) {
    return each->count(Claim::kUnsupported) == most;
  });
  return "refused " + std::to_string(most) + " of " + std::to_string(cell->trials) +
         (cell->refusal.empty() ? "" : ": " + cell->refusal);
}

std::int64_t Grid::trials() const {
  std::int64_t fewest = std::numeric_limits<std::int64_t>::max();
  for (const Cell* cell : cells) fewest = std::min(fewest, cell->trials);
  return cells.empty() ? 0 : fewest;
}

std::optional<PaperSet> paper_set(const std::string& name) {
  static const std::regex paper("paper/(monotone|copositive)/(exp[1-4]|exp[56]-1e(5|8|10)|extra100)");
  const Spec spec = spec_or_name(name);
  std::smatch parts;
  if (!std::regex_match(spec.name, parts, paper)) return std::nullopt;
  PaperSet set{parts[1], parts[2], parts[2] != "exp1" && parts[2] != "exp3", "multiple", ""};
  for (const auto& [key, value] : spec.options) {
    if (key == kRedundancy) set.redundancy = value;
    else set.other_readings += (set.other_readings.empty() ? "" : ",") + key + "=" + value;
  }
  return set;
}

std::vector<Grid> grids(const Summary& summary) {
  std::vector<Grid> grids;
  std::map<std::tuple<std::size_t, std::string, std::string, std::string, std::string>, std::size_t> places;
  for (const Cell& cell : summary.cells) {
    const SolverRow& row = summary.solvers[cell.solver];
    if (row.sweep.empty() || cell.refused()) continue;
    const std::optional<PaperSet> problems = paper_set(summary.sets[cell.set].name);
    if (!problems) continue;
    const auto [place, is_new] =
        places.try_emplace({cell.set, row.name + " " + row.sweep, row.isa, row.library, row.version}, grids.size());
    if (is_new) {
      auto [solver, sweep] = solver_and_sweep(row);
      std::string label = sweep == kPaperSweep ? solver : solver + " (sweep " + sweep + ")";
      grids.push_back({cell.set, *problems, std::move(solver), std::move(sweep), row.isa,
                       row.library + " " + row.version, std::move(label), {}});
    }
    grids[place->second].cells.push_back(&cell);
  }
  tell_builds_apart(grids);
  std::stable_sort(grids.begin(), grids.end(), [](const Grid& a, const Grid& b) {
    return a.set != b.set ? a.set < b.set : natural_less(a.label, b.label);
  });
  return grids;
}

std::string wrapped_solver(const std::string& solver) {
  const Spec spec = spec_or_name(solver);
  if (spec.name != kRegularized) return "";
  const std::string* wrapped = find_option(spec.options, "solver");
  return wrapped == nullptr ? kDefaultWrapped : *wrapped;
}

std::string family_of(const std::string& solver) {
  const std::string wrapped = wrapped_solver(solver);
  const std::string name = spec_or_name(wrapped.empty() ? solver : wrapped).name;
  return name == "lemke" ? "Lemke" : name == "path" ? "PATH" : name == "primal_dual" ? "IP" : "";
}

bool follows_rules_2012(const std::string& solver) {
  const std::string wrapped = wrapped_solver(solver);
  const Spec spec = spec_or_name(wrapped.empty() ? solver : wrapped);
  const std::string* rules = find_option(spec.options, "rules");
  return rules != nullptr && *rules == "2012";
}

const char* name_of(Measure measure) {
  switch (measure) {
    case Measure::kCriterion: return "criterion";
    case Measure::kCriterionAny: return "criterion_any";
    case Measure::kVerdict: break;
  }
  return "verdict";
}

Proportion solved_share(const Cell& cell, Measure measure) { return share_of(cell, measure); }

GridRange range_of(const Grid& grid, Measure measure) {
  GridRange range;
  std::vector<double> shares;
  double fewest = kInfinity;
  for (const Cell* cell : grid.cells) {
    const Proportion share = solved_share(*cell, measure);
    if (!(share.trials > 0)) continue;
    shares.push_back(share.value());
    fewest = std::min(fewest, share.trials);
    if (range.worst_cell == nullptr || share.value() < range.worst.value()) {
      range.worst = share;
      range.worst_cell = cell;
    }
    if (range.best_cell == nullptr || share.value() > range.best.value()) {
      range.best = share;
      range.best_cell = cell;
    }
  }
  range.sigma = spread(shares).sigma;
  if (shares.empty()) return range;
  double average = 0;
  for (const double share : shares) average += share / static_cast<double>(shares.size());
  average = std::clamp(average, range.worst.value(), range.best.value());  // the sum is rounded
  range.average = {average * fewest, fewest};
  range.chosen = choose(grid, measure);
  if (range.chosen == nullptr) return range;
  range.chosen_even = share_of(range.chosen->halves[0], measure);
  range.held_out = share_of(range.chosen->halves[1], measure);
  range.worst_held_out = share_of(choose(grid, measure, false)->halves[1], measure);
  return range;
}

PooledMean at_best(const Grid& grid, Quantity quantity, Measure measure) {
  const Cell* chosen = choose(grid, measure);
  return chosen == nullptr ? pooled_mean({}) : pooled_mean({spread_of(chosen->halves[1], quantity, measure)});
}

PooledMean over_all(const Grid& grid, Quantity quantity, Measure measure) {
  std::vector<Spread> parts;
  parts.reserve(grid.cells.size());
  for (const Cell* cell : grid.cells) parts.push_back(spread_of(*cell, quantity, measure));
  return pooled_mean(parts);
}

}  // namespace lcpbench::paper
