// Counts what choose() pools: the first two functions of decision.h.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "study/report/decision.h"
#include "study/report/sets.h"

namespace lcpbench::report {
namespace {

using Bits = std::uint16_t;  // one for each of kErrorGrid

/// One problem as one solver met it, in the terms of the grid of errors.
struct Mark {
  Bits solved = 0;
  Bits wrong = 0;
  bool taken = false;
  bool unsolvable = false;
  double log_time = kNoNumber;
};

Mark mark_of(const Outcome& outcome) {
  Mark mark{.taken = !outcome.refused(), .unsolvable = outcome.unsolvable(), .log_time = std::log(outcome.time_s)};
  if (!mark.taken) return mark;
  for (std::size_t i = 0; i < kErrors; ++i) {
    const auto bit = static_cast<Bits>(1U << i);
    const bool within = i == 0 ? outcome.solved() : outcome.error <= kErrorGrid[i];
    if (within && !mark.unsolvable) mark.solved |= bit;
    if (outcome.false_claim() && (mark.unsolvable || !within)) mark.wrong |= bit;
  }
  return mark;
}

/// Nine digits: the page has the same numbers as the program.
double rounded(double value) { return std::strtod(fmt::format("{:.9g}", value).c_str(), nullptr); }

LogSums rounded(const LogSums& sums) { return {sums.n, rounded(sums.sum), rounded(sums.square_sum)}; }

/// An entry of CellStatistics::profile.
std::int32_t profile_code(const Mark& mark) {
  if (!mark.taken || mark.unsolvable || !std::isfinite(mark.log_time)) return 0;
  const double hundredths = std::round(200 * (mark.log_time / std::log(10.0) + 9));
  const auto time = static_cast<std::int32_t>(std::clamp(hundredths, 0.0, 1e4)) + 1;
  return 32 * time + 16 * (mark.solved & 1) + std::popcount(static_cast<Bits>(mark.solved >> 1));
}

CellStatistics cell_statistics(const Summary& summary, const Cell& cell, const std::vector<Mark>& marks) {
  CellStatistics statistics{.set = cell.set, .solver = cell.solver};
  statistics.other_model = solves_other_model(summary.sets[cell.set], summary.solvers[cell.solver]);
  statistics.met = cell.trials;
  statistics.refused = cell.count(Claim::kUnsupported);
  statistics.crashed = cell.count(Claim::kCrashed);
  statistics.gave_up = cell.count(Verdict::kMissed) + cell.count(Verdict::kOpen);
  statistics.error_p99 = cell.error_p99;
  for (const Mark& mark : marks) {
    if (!mark.taken) continue;
    statistics.unsolvable += mark.unsolvable ? 1 : 0;
    for (std::size_t i = 0; i < kErrors; ++i) {
      statistics.solved[i] += mark.solved >> i & 1;
      statistics.wrong[i] += mark.wrong >> i & 1;
    }
    if (std::isfinite(mark.log_time)) statistics.time.add(mark.log_time);
  }
  statistics.time = rounded(statistics.time);
  for (std::size_t i = 0; i < std::min(marks.size(), kProfiled); ++i)
    statistics.profile.push_back(profile_code(marks[i]));
  return statistics;
}

/// Counts the problems that both took and that are unsolvable for both or for neither (Outcome::unsolvable()).
/// @param a  by problem of the set, as is b
PairStatistics compare(const std::vector<Mark>& a, const std::vector<Mark>& b) {
  PairStatistics pair;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Mark& left = a[i];
    const Mark& right = b[i];
    if (!left.taken || !right.taken || left.unsolvable != right.unsolvable) continue;
    ++pair.both_took;
    pair.both_unsolvable += left.unsolvable ? 1 : 0;
    const double log_ratio = right.log_time - left.log_time;
    for (std::size_t error = 0; error < kErrors; ++error) {
      PairStatistics::AtError& at = pair.at[error];
      at.only_a += (left.solved & ~right.solved) >> error & 1;
      at.only_b += (right.solved & ~left.solved) >> error & 1;
      at.wrong_a += (left.wrong & ~right.wrong) >> error & 1;
      at.wrong_b += (right.wrong & ~left.wrong) >> error & 1;
      if (std::isfinite(log_ratio) && ((left.solved & right.solved) >> error & 1) != 0) at.ratio.add(log_ratio);
    }
  }
  for (PairStatistics::AtError& at : pair.at) at.ratio = rounded(at.ratio);
  return pair;
}

}  // namespace

void add_statistics(const Summary& summary, std::size_t problems, std::span<const Cell> cells, Statistics& statistics) {
  std::vector<const Cell*> met;
  std::vector<std::vector<Mark>> marks;
  for (const Cell& cell : cells) {
    if (!summary.solvers[cell.solver].sweep.empty()) continue;
    std::vector<Mark> own(problems);
    for (const Outcome& outcome : cell.outcomes) own[outcome.problem] = mark_of(outcome);
    statistics.cells.push_back(cell_statistics(summary, cell, own));
    if (cell.refused()) continue;
    marks.push_back(std::move(own));
    met.push_back(&cell);
  }
  if (met.empty() || is_hard_set(summary.sets[met.front()->set].name)) return;
  for (std::size_t a = 0; a < met.size(); ++a) {
    for (std::size_t b = a + 1; b < met.size(); ++b) {
      PairStatistics pair = compare(marks[a], marks[b]);
      pair.set = met[a]->set;
      pair.a = met[a]->solver;
      pair.b = met[b]->solver;
      if (pair.both_took > 0) statistics.pairs.push_back(pair);
    }
  }
}

void complete_statistics(const Summary& summary, Statistics& statistics) {
  std::map<std::string, SetPlan> plans;
  for (const Coverage::Set& set : summary.coverage.sets) plans[set.name] = {set.planned, set.done};
  for (const SetSummary& set : summary.sets) {
    statistics.plans.push_back(summary.coverage.known ? plans[set.name] : SetPlan{});
  }
}

}  // namespace lcpbench::report
