#include "study/table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "study/text_table.h"

namespace lcpbench {
namespace {

/// All that is shown of one set and solver; the cells of a sweep share one.
struct Line {
  std::int64_t trials = 0;
  std::int64_t refused = 0;
  std::int64_t solved = 0;
  std::int64_t unsolvable = 0;
  std::int64_t false_claims = 0;
  std::vector<double> times;

  void add(const StoredCell& cell) {
    ++trials;
    if (cell.claim == Claim::kUnsupported) {
      ++refused;
      return;
    }
    if (cell.verdict == Verdict::kSolved) ++solved;
    if (cell.verdict == Verdict::kUnsolvable) ++unsolvable;
    if (false_claim(cell.claim, cell.verdict)) ++false_claims;
    times.push_back(cell.times.setup_cpu_s + cell.times.solve_cpu_s);
  }
};

std::string percent(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? fmt::format("{:.2f} %", 100.0 * static_cast<double>(part) / static_cast<double>(whole)) : "-";
}

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void print_table(Store& store, std::ostream& out) {
  std::map<std::int64_t, std::string> solver_labels;
  for (const StoredSolver& solver : store.solvers()) {
    solver_labels[solver.id] =
        solver.row.sweep.empty() ? solver.row.text() : fmt::format("{}, sweep {}", solver.row.name, solver.row.sweep);
  }
  std::map<std::int64_t, std::string> set_names;
  for (auto& [id, name] : store.sets()) set_names[id] = std::move(name);
  std::map<std::pair<std::string, std::string>, Line> lines;
  store.for_each_cell([&](const StoredCell& cell) {
    lines[{set_names[cell.set_id], solver_labels[cell.solver_id]}].add(cell);
  });

  using Align = TextTable::Align;
  TextTable table(
      {{"set", Align::kLeft}, {"solver", Align::kLeft}, {"trials"}, {"solved"}, {"false claims"}, {"median time"}});
  std::string last_set;
  for (const auto& [key, line] : lines) {
    const auto& [set, solver] = key;
    if (!last_set.empty() && set != last_set) table.add_gap();
    const std::string shown_set = set == last_set ? "" : set;
    last_set = set;
    if (line.refused == line.trials) {
      table.add_row({shown_set, solver, format_count(line.trials), "not its kind"});
      continue;
    }
    table.add_row({shown_set, solver, format_count(line.trials),
                   percent(line.solved, line.trials - line.refused - line.unsolvable),
                   percent(line.false_claims, line.trials - line.refused), format_seconds(median(line.times))});
  }
  out << table.text() << std::flush;
}

}  // namespace lcpbench
