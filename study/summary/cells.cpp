#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "study/summary/summary.h"

namespace lcpbench {
namespace {

/// A rate of every cell of a sweep; NaN rates (all problems unsolvable) leave the range NaN.
SweepSummary::Range range_over(const Summary& summary, const std::vector<const Cell*>& cells,
                               double (Part::*rate)() const) {
  SweepSummary::Range range{kInfinity, 0, -kInfinity, "", ""};
  for (const Cell* cell : cells) {
    const double value = (cell->*rate)();
    if (std::isnan(value)) return {kNoNumber, kNoNumber, kNoNumber, "", ""};
    const std::string& settings = summary.solvers[cell->solver].settings;
    range.average += value / static_cast<double>(cells.size());
    if (value < range.worst) {
      range.worst = value;
      range.worst_settings = settings;
    }
    if (value > range.best) {
      range.best = value;
      range.best_settings = settings;
    }
  }
  range.average = std::clamp(range.average, range.worst, range.best);  // the sum is rounded
  return range;
}

double best_held_out(const std::vector<const Cell*>& cells) {
  const Cell* best = nullptr;
  for (const Cell* cell : cells) {
    if (std::isnan(cell->halves[0].rate())) continue;
    if (best == nullptr || cell->halves[0].rate() > best->halves[0].rate()) best = cell;
  }
  return best == nullptr ? kNoNumber : best->halves[1].rate();
}

}  // namespace

std::int64_t Cell::count(Verdict verdict) const {
  std::int64_t total = 0;
  for (const Claim claim : kAllClaims) total += count(claim, verdict);
  return total;
}

std::int64_t Cell::count(Claim claim) const {
  const auto& verdicts = counts[static_cast<std::size_t>(claim)];
  return std::accumulate(verdicts.begin(), verdicts.end(), std::int64_t{0});
}

std::int64_t Cell::count(Claim claim, Verdict verdict) const {
  return counts[static_cast<std::size_t>(claim)][static_cast<std::size_t>(verdict)];
}

std::int64_t Cell::gave_up() const {
  return count(Verdict::kRefused) + count(Verdict::kMissed) + count(Verdict::kOpen);
}

double Part::rate() const { return share_of(solved, solvable()); }
double Part::criterion_rate() const { return share_of(criterion, trials); }

std::vector<SweepSummary> summarize_sweeps(const Summary& summary) {
  std::map<SweepOfSet, std::vector<const Cell*>> groups;
  for (const Cell& cell : summary.cells) {
    const SolverRow& solver = summary.solvers[cell.solver];
    if (solver.sweep.empty()) continue;
    groups[{cell.set, solver.name, solver.sweep, solver.isa, solver.library, solver.version}].push_back(&cell);
  }
  std::vector<SweepSummary> sweeps;
  for (const auto& [shared, cells] : groups) {
    SweepSummary& sweep = sweeps.emplace_back(SweepSummary{shared});
    sweep.parameterisations = std::ssize(cells);
    sweep.trials = std::ranges::min(cells, {}, &Cell::trials)->trials;
    sweep.verdict = range_over(summary, cells, &Cell::rate);
    sweep.criterion = range_over(summary, cells, &Cell::criterion_rate);
    sweep.best_held_out = best_held_out(cells);
  }
  return sweeps;
}

}  // namespace lcpbench
