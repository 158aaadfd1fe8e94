#include "study/report/ecdf_figures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "study/report/axes.h"
#include "study/report/curves.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

constexpr int kPointsPerDecade = 20;    // finer than what can be told apart in the picture
constexpr double kErrorCeiling = 1e2;   // answers with larger errors have no step
constexpr double kShortestTime = 1e-8;  // [s] about what a clock resolves; quicker solves are drawn here

/// The values that a logarithmic axis can show, those below `floor` raised to it.
std::vector<double> drawable(const std::vector<double>& values, double floor) {
  std::vector<double> kept;
  for (const double value : values) {
    if (std::isfinite(value) && value >= 0) kept.push_back(std::max(value, floor));
  }
  return kept;
}

/// The empirical distribution on a grid fine enough for the eye; points where it does not rise are left out.
std::vector<std::pair<double, double>> steps(const std::vector<double>& values, std::int64_t problems) {
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
    std::vector<double> kept = drawable(distribution.*values, floor);
    std::erase_if(kept, [ceiling](double value) { return value > ceiling; });
    if (kept.empty()) continue;
    std::string label = solver_label(summary, distribution.solver);
    if (distribution.problems < summary.sets[comparison.set].problems) {
      label += fmt::format(" ({} of {})", distribution.problems, summary.sets[comparison.set].problems);
    }
    curves.push_back({shorten(label, 44), i, steps(kept, distribution.problems)});
  }
  return curves;
}

}  // namespace

std::optional<Figure> time_ecdf_figure(const Summary& summary, const SetComparison& comparison) {
  const SetSummary& set = summary.sets[comparison.set];
  const std::vector<Curve> curves =
      curves_of(summary, comparison, &Distribution::times_s, kShortestTime, std::numeric_limits<double>::max());
  if (curves.empty()) return std::nullopt;
  ShareAxes axes;
  axes.title = describe(set) + ": share solved within a time";
  axes.alternative = describe(set) + ": share of problems solved within a time." + ends_in_words(curves);
  axes.heading = "Share of the problems solved within a time; failures stay below the curve";
  axes.x_label = "time per problem, set-up and solve (CPU)";
  axes.tic = time_of_decade;
  return Figure{draw_shares(set, axes, curves), axes.alternative, ""};
}

std::optional<Figure> error_ecdf_figure(const Summary& summary, const SetComparison& comparison) {
  const SetSummary& set = summary.sets[comparison.set];
  const std::vector<Curve> curves = curves_of(summary, comparison, &Distribution::errors, kErrorFloor, kErrorCeiling);
  if (curves.empty()) return std::nullopt;
  ShareAxes axes;
  axes.title = describe(set) + ": share answered within an error";
  axes.alternative = describe(set) + ": share of problems answered within an error." + ends_in_words(curves);
  axes.heading = "Share of the problems answered within an error, whatever the solver claimed";
  axes.x_label = set.bare ? "error: backward error" : "error ρ: relative velocity residual";
  axes.tic = power_of_ten;
  axes.bound = verdict_bound(set);
  return Figure{draw_shares(set, axes, curves), axes.alternative, ""};
}

}  // namespace lcpbench::report
