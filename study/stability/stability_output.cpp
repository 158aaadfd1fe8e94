#include "study/stability/stability_output.h"

#include <algorithm>
#include <set>
#include <tuple>
#include <vector>

#include <fmt/format.h>

#include "study/output/json_output.h"
#include "study/output/terminal.h"
#include "study/output/text_table.h"
#include "study/statistics/statistics.h"

namespace lcpbench {
namespace {

using Cells = std::vector<const StabilityCell*>;

std::size_t solvers_that(const StabilityResult& result, bool (StabilityCell::*holds)() const) {
  std::set<std::size_t> solvers;
  for (const StabilityCell& cell : result.cells) {
    if ((cell.*holds)()) solvers.insert(cell.solver);
  }
  return solvers.size();
}

/// Those that turn honest answers into false claims first, then by the share of solved problems that they lose, then by
/// how far their answers move. @param all  with those that neither break nor move too far
Cells gravest_first(const StabilityResult& result, bool all) {
  Cells cells;
  for (const StabilityCell& cell : result.cells) {
    if (cell.asked > 0 && (all || cell.breaks() || cell.moves_too_far())) cells.push_back(&cell);
  }
  const auto gravity = [](const StabilityCell& cell) {
    const double lost_share = cell.solved > 0 ? static_cast<double>(cell.lost()) / static_cast<double>(cell.solved) : 0;
    return std::tuple(cell.turned_false, lost_share, cell.amplifications.empty() ? 0.0 : cell.largest_amplification());
  };
  std::stable_sort(cells.begin(), cells.end(),
                   [&](const StabilityCell* a, const StabilityCell* b) { return gravity(*a) > gravity(*b); });
  return cells;
}

std::string cells_table(const StabilityResult& result, const Cells& cells, std::size_t rows, int width) {
  using Align = TextTable::Align;
  TextTable table({{"solver", Align::kLeft},
                   {"under", Align::kLeft},
                   {"lost"},
                   {"turned false"},
                   {"moves", Align::kRight, 1},
                   {"first on", Align::kLeft, 2, 30}});
  for (std::size_t i = 0; i < rows; ++i) {
    const StabilityCell& cell = *cells[i];
    table.add_row({result.solvers[cell.solver], to_string(cell.change),
                   fmt::format("{} of {}", cell.lost(), cell.solved),
                   fmt::format("{} of {}", cell.turned_false, cell.honest),
                   cell.amplifications.empty() ? "" : fmt::format("{:.2g}", cell.largest_amplification()),
                   cell.breaks() ? cell.examples.at(0) : cell.farthest});
  }
  return (table.empty() ? "" : table.text(width)) +
         (cells.size() > rows ? fmt::format("and {} more: --long shows them\n", cells.size() - rows) : "");
}

Json cell_json(const StabilityCell& cell, const std::string& solver) {
  const Interval share = wilson(cell.kept, cell.solved);
  return {{"change", to_string(cell.change)},
          {"solver", solver},
          {"asked", cell.asked},
          {"solved", cell.solved},
          {"kept", cell.kept},
          {"kept_low", json_number(share.low)},
          {"kept_high", json_number(share.high)},
          {"honest", cell.honest},
          {"turned_false", cell.turned_false},
          {"amplification",
           {{"problems", cell.amplifications.size()},
            {"median", json_number(spread(cell.amplifications).median)},
            {"max", json_number(cell.largest_amplification())}}},
          {"breaks", cell.breaks()},
          {"moves_too_far", cell.moves_too_far()},
          {"farthest", cell.farthest.empty() ? Json(nullptr) : Json(cell.farthest)},
          {"examples", cell.examples}};
}

}  // namespace

std::string stability_text(const StabilityResult& result, bool all, int width) {
  const std::size_t moving = solvers_that(result, &StabilityCell::moves_too_far);
  std::string scope = counted_noun(static_cast<std::size_t>(result.problems - result.left_out), "problem") + " of " +
                      counted_noun(result.sets.size(), "set");
  if (result.left_out > 0) {
    scope += fmt::format(", {} left out (above {} unknowns)", result.left_out, kLargestStabilityOrder);
  }
  const std::string end =
      folded(fmt::format("{}: {} of {} break (lose a problem that they solved, or turn an honest answer into a false "
                         "claim), {} move{} more than {} times further than conditioning allows\n",
                         scope, solvers_that(result, &StabilityCell::breaks),
                         counted_noun(result.solvers.size(), "solver"), moving, moving == 1 ? "s" : "",
                         kAllowedAmplification),
             width);
  const Cells cells = gravest_first(result, all);
  if (all) return cells_table(result, cells, cells.size(), width) + end;
  return fitting_text(cells.size(), kAnswerLines,
                      [&](std::size_t rows) { return cells_table(result, cells, rows, width) + end; });
}

Json stability_json(const StabilityResult& result) {
  Json cells = Json::array();
  for (const StabilityCell& cell : result.cells) {
    if (cell.asked > 0) cells.push_back(cell_json(cell, result.solvers[cell.solver]));
  }
  return cells;
}

}  // namespace lcpbench
