#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "study/report/axes.h"
#include "study/report/figures.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

constexpr int kPointsPerDecade = 20;    // finer than what can be told apart in the picture
constexpr double kShortestTime = 1e-8;  // [s] about what a clock resolves; quicker solves are drawn here

/// The values that a logarithmic axis can show, those below `floor` raised to it.
std::vector<double> drawable(const std::vector<double>& values, double floor, double ceiling) {
  std::vector<double> kept;
  for (const double value : values) {
    if (std::isfinite(value) && value >= 0 && value <= ceiling) kept.push_back(std::max(value, floor));
  }
  return kept;
}

/// The empirical distribution, a step at every value.
std::vector<std::pair<double, double>> every_step(const std::vector<double>& sorted, std::int64_t problems) {
  std::vector<std::pair<double, double>> steps;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const bool last_of_equals = i + 1 == sorted.size() || sorted[i + 1] > sorted[i];
    if (last_of_equals) steps.emplace_back(sorted[i], static_cast<double>(i + 1) / static_cast<double>(problems));
  }
  return steps;
}

/// The empirical distribution on a grid fine enough for the eye; points where it does not rise are left out.
std::vector<std::pair<double, double>> grid_steps(const std::vector<double>& values, std::int64_t problems) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  const std::vector<double> grid = decade_grid(static_cast<int>(std::floor(std::log10(*least))),
                                               static_cast<int>(std::floor(std::log10(*most))) + 1, kPointsPerDecade);
  const std::vector<double> shares = ecdf(values, problems, grid);
  std::vector<std::pair<double, double>> steps;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    if (shares[i] > (steps.empty() ? 0.0 : steps.back().second)) steps.emplace_back(grid[i], shares[i]);
  }
  return steps;
}

std::vector<Curve> curves_of(const Summary& summary, const SetComparison& comparison,
                             std::vector<double> Distribution::*values, double floor, double ceiling) {
  std::vector<Curve> curves;
  for (std::size_t i = 0; i < comparison.distributions.size(); ++i) {
    const Distribution& distribution = comparison.distributions[i];
    const std::vector<double> kept = drawable(distribution.*values, floor, ceiling);
    if (kept.empty()) continue;
    const std::int64_t problems = summary.sets[comparison.set].problems;
    const std::string label = solver_label(summary, distribution.solver);
    curves.push_back({sized_label(label, distribution.problems, problems), i, grid_steps(kept, distribution.problems)});
  }
  return curves;
}

/// The curves with their words; nullopt where there is none.
std::optional<Figure> figure_of(const SetSummary& set, const std::vector<Curve>& curves, const char* title,
                                const char* shares, ShareAxes axes) {
  if (curves.empty()) return std::nullopt;
  axes.title = describe(set) + ": " + title;
  axes.alternative = describe(set) + ": share of problems " + shares + "." + ends_in_words(curves);
  return Figure{draw_shares(set, axes, curves), axes.alternative, ""};
}

ShareAxes error_axes(const SetSummary& set, const char* heading) {
  return {.heading = heading,
          .x_label = set.bare ? "error: backward error" : "error ρ: relative velocity residual",
          .tic = power_of_ten,
          .bound = verdict_bound(set)};
}

}  // namespace

std::vector<const Cell*> drawn_cells(const Summary& summary, std::size_t set) {
  std::vector<const Cell*> cells;
  for (const Cell& cell : summary.cells) {
    if (cell.set == set && summary.solvers[cell.solver].sweep.empty() && !cell.refused()) cells.push_back(&cell);
  }
  return cells;
}

std::optional<Figure> error_distribution_figure(const Summary& summary, std::size_t set_index) {
  const SetSummary& set = summary.sets[set_index];
  const std::vector<const Cell*> cells = drawn_cells(summary, set_index);
  std::vector<Curve> curves;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::vector<double> errors = drawable(cells[i]->errors, kErrorFloor, std::numeric_limits<double>::max());
    if (errors.empty()) continue;
    const std::string& label = summary.solvers[cells[i]->solver].text();
    curves.push_back({sized_label(label, cells[i]->trials, set.problems), i, every_step(errors, cells[i]->trials)});
  }
  return figure_of(set, curves, "distribution of the error", "answered within an error",
                   error_axes(set, "Share of all problems answered within an error, of answers said to be solved"));
}

std::optional<Figure> time_ecdf_figure(const Summary& summary, const SetComparison& comparison) {
  return figure_of(
      summary.sets[comparison.set],
      curves_of(summary, comparison, &Distribution::times_s, kShortestTime, std::numeric_limits<double>::max()),
      "share solved within a time", "solved within a time",
      {.heading = "Share of the problems solved within a time; failures stay below the curve",
       .x_label = "time per problem, set-up and solve (CPU)",
       .tic = time_of_decade});
}

std::optional<Figure> error_ecdf_figure(const Summary& summary, const SetComparison& comparison) {
  const SetSummary& set = summary.sets[comparison.set];
  return figure_of(set, curves_of(summary, comparison, &Distribution::errors, kErrorFloor, kErrorCeiling),
                   "share answered within an error", "answered within an error",
                   error_axes(set, "Share of the problems answered within an error, whatever the solver claimed"));
}

}  // namespace lcpbench::report
