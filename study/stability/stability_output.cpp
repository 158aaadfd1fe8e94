#include "study/stability/stability_output.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "study/output/json_output.h"
#include "study/statistics/statistics.h"
#include "study/output/terminal.h"
#include "study/output/text_table.h"

namespace lcpbench {
namespace {

using Json = nlohmann::ordered_json;
using CellText = std::function<std::string(const StabilityCell&)>;

/// NaN counts as the largest.
std::vector<double> sorted(std::vector<double> values) {
  for (double& value : values) {
    if (std::isnan(value)) value = std::numeric_limits<double>::infinity();
  }
  std::sort(values.begin(), values.end());
  return values;
}

double middle(const std::vector<double>& values) { return median(sorted(values)); }

double most(const std::vector<double>& values) {
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : sorted(values).back();
}

std::vector<const StabilityCell*> cells_of(const StabilityResult& result, TransformationKind kind) {
  std::vector<const StabilityCell*> cells;
  for (const StabilityCell& cell : result.cells) {
    if (cell.kind == kind) cells.push_back(&cell);
  }
  return cells;
}

/// Kinds for which some solver has something to show.
std::vector<TransformationKind> kinds_with(const StabilityResult& result,
                                           const std::function<bool(const StabilityCell&)>& shows) {
  std::vector<TransformationKind> kinds;
  for (const TransformationKind kind : kAllTransformations) {
    const std::vector<const StabilityCell*> cells = cells_of(result, kind);
    if (std::any_of(cells.begin(), cells.end(), [&](const StabilityCell* cell) { return shows(*cell); })) {
      kinds.push_back(kind);
    }
  }
  return kinds;
}

/// A row for each solver and a column for each kind, under a title; "" where no solver has anything to show.
std::string matrix(const char* title, const StabilityResult& result, int width,
                   const std::function<bool(const StabilityCell&)>& shows, const CellText& text) {
  const std::vector<TransformationKind> kinds = kinds_with(result, shows);
  if (kinds.empty()) return "";
  std::vector<TextTable::Column> columns{{"solver", TextTable::Align::kLeft}};
  for (const TransformationKind kind : kinds) {
    columns.push_back({to_string(kind), TextTable::Align::kRight, static_cast<int>(columns.size())});
  }
  TextTable table(columns);
  for (std::size_t s = 0; s < result.solvers.size(); ++s) {
    std::vector<std::string> row{result.solvers[s]};
    bool any = false;
    for (const TransformationKind kind : kinds) {
      const StabilityCell& cell = *cells_of(result, kind)[s];
      any = any || shows(cell);
      row.push_back(shows(cell) ? text(cell) : "");
    }
    if (any) table.add_row(std::move(row));
  }
  return std::string("\n") + title + "\n" + table.text(width);
}

std::string kept_text(const StabilityCell& cell) {
  return fmt::format("{}/{}{}", cell.kept, cell.solved,
                     cell.turned_false > 0 ? fmt::format(" !{}", cell.turned_false) : "");
}

std::string median_and_most(const std::vector<double>& values) {
  return fmt::format("{:.2g} {:.2g}", middle(values), most(values));
}

std::string breaks_text(const StabilityCell& cell, const std::string& solver) {
  std::string text = fmt::format("{} under {}:", solver, to_string(cell.kind));
  if (cell.lost() > 0) {
    const Interval share = wilson(cell.kept, cell.solved);
    text += fmt::format(" {} of {} solved problems lost (kept {:.1f} %, 95 % interval {:.1f} to {:.1f} %)", cell.lost(),
                        cell.solved, 100.0 * static_cast<double>(cell.kept) / static_cast<double>(cell.solved),
                        100 * share.low, 100 * share.high);
  }
  if (cell.turned_false > 0) {
    text += fmt::format("{} {} of {} honest answers turned into false claims", cell.lost() > 0 ? ";" : "",
                        cell.turned_false, cell.honest);
  }
  return text + "; first: " + cell.examples.at(0);
}

constexpr std::size_t kMovesShown = 4;

std::string and_more(std::size_t all, std::size_t shown) {
  return all > shown ? fmt::format("and {} more: --long shows them\n", all - shown) : "";
}

/// Those that turn honest answers into false claims first, then by the share of solved problems that they lose.
std::vector<const StabilityCell*> gravest_breaks(const StabilityResult& result) {
  std::vector<const StabilityCell*> broken;
  for (const StabilityCell& cell : result.cells) {
    if (cell.breaks()) broken.push_back(&cell);
  }
  const auto lost_share = [](const StabilityCell& cell) {
    return cell.solved > 0 ? static_cast<double>(cell.lost()) / static_cast<double>(cell.solved) : 0.0;
  };
  std::stable_sort(broken.begin(), broken.end(), [&](const StabilityCell* a, const StabilityCell* b) {
    return std::pair(a->turned_false, lost_share(*a)) > std::pair(b->turned_false, lost_share(*b));
  });
  return broken;
}

std::string breaks_table(const StabilityResult& result, const std::vector<const StabilityCell*>& broken,
                         std::size_t rows, int width) {
  using Align = TextTable::Align;
  TextTable table({{"breaks", Align::kLeft},
                   {"under", Align::kLeft},
                   {"lost"},
                   {"turned false"},
                   {"first on", Align::kLeft, 1, 30}});
  for (std::size_t i = 0; i < rows; ++i) {
    const StabilityCell& cell = *broken[i];
    table.add_row({result.solvers[cell.solver], to_string(cell.kind), fmt::format("{} of {}", cell.lost(), cell.solved),
                   fmt::format("{} of {}", cell.turned_false, cell.honest), cell.examples.at(0)});
  }
  return (table.empty() ? "" : table.text(width)) + and_more(broken.size(), rows);
}

std::string farthest_moves(const StabilityResult& result, int width) {
  std::vector<const StabilityCell*> moved;
  for (const StabilityCell& cell : result.cells) {
    if (cell.moves_too_far()) moved.push_back(&cell);
  }
  std::stable_sort(moved.begin(), moved.end(), [](const StabilityCell* a, const StabilityCell* b) {
    return a->largest_amplification() > b->largest_amplification();
  });
  std::string text;
  for (std::size_t i = 0; i < std::min(moved.size(), kMovesShown); ++i) {
    text += folded(
        fmt::format("{} moves up to {:.2g} times what conditioning allows, under {}\n",
                    result.solvers[moved[i]->solver], moved[i]->largest_amplification(), to_string(moved[i]->kind)),
        width);
  }
  return text + and_more(moved.size(), kMovesShown);
}

/// How many solvers have a cell for which this holds.
std::size_t solvers_with(const StabilityResult& result, bool (StabilityCell::*holds)() const) {
  std::set<std::size_t> solvers;
  for (const StabilityCell& cell : result.cells) {
    if ((cell.*holds)()) solvers.insert(cell.solver);
  }
  return solvers.size();
}

std::string scope_text(const StabilityResult& result) {
  const auto problems = static_cast<std::size_t>(result.problems - result.left_out);
  std::string text = counted_noun(problems, "problem") + " of " + counted_noun(result.sets.size(), "set");
  if (result.left_out > 0) {
    text += fmt::format(", {} left out (above {} unknowns)", result.left_out, kLargestStabilityOrder);
  }
  return text;
}

std::string names(const StabilityResult& result, int width) {
  std::string broken;
  std::string moved;
  for (const StabilityCell& cell : result.cells) {
    const std::string& solver = result.solvers[cell.solver];
    if (cell.breaks()) broken += "  " + breaks_text(cell, solver) + "\n";
    if (!cell.moves_too_far()) continue;
    moved += fmt::format("  {} under {}: up to {:.2g} times what conditioning allows, on {}\n", solver,
                         to_string(cell.kind), cell.largest_amplification(), cell.farthest);
  }
  return folded((broken.empty() ? "\nnone breaks\n" : "\nbreaks:\n" + broken) +
                    (moved.empty() ? "none moves further than conditioning allows\n"
                                   : "moves further than conditioning allows:\n" + moved),
                width);
}

Json spread_json(const std::vector<double>& values) {
  return {{"problems", values.size()}, {"median", json_number(middle(values))}, {"max", json_number(most(values))}};
}

Json cell_json(const StabilityCell& cell, const std::string& solver) {
  const Interval share = wilson(cell.kept, cell.solved);
  return {{"transformation", to_string(cell.kind)},
          {"solver", solver},
          {"asked", cell.asked},
          {"solved", cell.solved},
          {"kept", cell.kept},
          {"kept_low", json_number(share.low)},
          {"kept_high", json_number(share.high)},
          {"honest", cell.honest},
          {"turned_false", cell.turned_false},
          {"change", spread_json(cell.changes)},
          {"amplification", spread_json(cell.amplifications)},
          {"distance", spread_json(cell.distances)},
          {"residual", spread_json(cell.residuals)},
          {"pivot_spread", spread_json(cell.pivot_spreads)},
          {"breaks", cell.breaks()},
          {"moves_too_far", cell.moves_too_far()},
          {"farthest", cell.farthest.empty() ? Json(nullptr) : Json(cell.farthest)},
          {"examples", cell.examples}};
}

}  // namespace

std::string stability_answer(const StabilityResult& result, int width) {
  const std::size_t moving = solvers_with(result, &StabilityCell::moves_too_far);
  const std::string end =
      farthest_moves(result, width) +
      folded(fmt::format("{}: {} of {} break (lose a problem that they solved, or turn an honest answer into a false "
                         "claim), {} move{} further than conditioning allows\n",
                         scope_text(result), solvers_with(result, &StabilityCell::breaks),
                         counted_noun(result.solvers.size(), "solver"), moving, moving == 1 ? "s" : ""),
             width);
  const std::vector<const StabilityCell*> broken = gravest_breaks(result);
  return fitting_text(broken.size(), kAnswerLines,
                      [&](std::size_t rows) { return breaks_table(result, broken, rows, width) + end; });
}

std::string stability_text(const StabilityResult& result, int width) {
  const auto asked = [](const StabilityCell& cell) { return cell.asked > 0; };
  const auto moved = [](const StabilityCell& cell) { return !cell.amplifications.empty(); };
  const auto pivots = [](const StabilityCell& cell) {
    return cell.kind == TransformationKind::kPermutation && !cell.pivot_spreads.empty();
  };
  return scope_text(result) + "\n" +
         matrix("still solved, of those solved before (!: answers turned into false claims)", result, width, asked,
                kept_text) +
         matrix("amplification, median and largest (1: what conditioning allows)", result, width, moved,
                [](const StabilityCell& cell) { return median_and_most(cell.amplifications); }) +
         matrix("most over fewest pivots of one problem, median and largest", result, width, pivots,
                [](const StabilityCell& cell) { return median_and_most(cell.pivot_spreads); }) +
         names(result, width);
}

Json stability_json(const StabilityResult& result) {
  Json cells = Json::array();
  for (const StabilityCell& cell : result.cells) {
    if (cell.asked > 0) cells.push_back(cell_json(cell, result.solvers[cell.solver]));
  }
  return cells;
}

}  // namespace lcpbench
