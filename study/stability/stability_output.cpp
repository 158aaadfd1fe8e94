#include "study/stability/stability_output.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include "study/json_output.h"
#include "study/statistics.h"
#include "study/text_table.h"

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

std::string matrix(const StabilityResult& result, const std::function<bool(const StabilityCell&)>& shows,
                   const CellText& text) {
  const std::vector<TransformationKind> kinds = kinds_with(result, shows);
  std::vector<TextTable::Column> columns{{"solver", TextTable::Align::kLeft}};
  for (const TransformationKind kind : kinds) columns.push_back({to_string(kind)});
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
  return table.text();
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

std::string names(const StabilityResult& result) {
  std::string broken;
  std::string moved;
  for (const StabilityCell& cell : result.cells) {
    const std::string& solver = result.solvers[cell.solver];
    if (cell.breaks()) broken += "  " + breaks_text(cell, solver) + "\n";
    if (!cell.moves_too_far()) continue;
    moved += fmt::format("  {} under {}: up to {:.2g} times what conditioning allows, on {}\n", solver,
                         to_string(cell.kind), cell.largest_amplification(), cell.farthest);
  }
  return (broken.empty() ? "\nnone breaks\n" : "\nbreaks:\n" + broken) +
         (moved.empty() ? "none moves further than conditioning allows\n"
                        : "moves further than conditioning allows:\n" + moved);
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

std::string stability_text(const StabilityResult& result) {
  const auto asked = [](const StabilityCell& cell) { return cell.asked > 0; };
  const auto moved = [](const StabilityCell& cell) { return !cell.amplifications.empty(); };
  const auto pivots = [](const StabilityCell& cell) {
    return cell.kind == TransformationKind::kPermutation && !cell.pivot_spreads.empty();
  };
  const auto plural = [](auto count) { return count == 1 ? "" : "s"; };
  const auto problems = result.problems - result.left_out;
  std::string text = fmt::format("{} problem{} of {} set{}", problems, plural(problems), result.sets.size(),
                                 plural(result.sets.size()));
  if (result.left_out > 0) {
    text += fmt::format(", {} left out (above {} unknowns)", result.left_out, kLargestStabilityOrder);
  }
  text += "\n\nstill solved, of those solved before (!: answers turned into false claims)\n" +
          matrix(result, asked, kept_text);
  // A table without rows says nothing: frictional problems and bare LCPs have no amplification, and some solvers no
  // pivots.
  const auto add = [&](const char* heading, const auto& shows, const auto& values) {
    if (std::none_of(result.cells.begin(), result.cells.end(), shows)) return;
    text += heading;
    text += matrix(result, shows, [&values](const StabilityCell& cell) { return median_and_most(values(cell)); });
  };
  add("\namplification, median and largest (1: what conditioning allows)\n", moved,
      [](const StabilityCell& cell) { return cell.amplifications; });
  add("\nmost over fewest pivots of one problem, median and largest\n", pivots,
      [](const StabilityCell& cell) { return cell.pivot_spreads; });
  return text + names(result);
}

Json stability_json(const StabilityResult& result) {
  Json cells = Json::array();
  for (const StabilityCell& cell : result.cells) {
    if (cell.asked > 0) cells.push_back(cell_json(cell, result.solvers[cell.solver]));
  }
  return cells;
}

}  // namespace lcpbench
