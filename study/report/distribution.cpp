#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "study/report/axes.h"
#include "study/report/curves.h"
#include "study/report/figures.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

/// Finite errors, clamped to what the axis shows.
std::vector<double> finite_errors(const Cell& cell) {
  std::vector<double> errors;
  for (const double error : cell.errors) {
    if (std::isfinite(error)) errors.push_back(std::max(error, kErrorFloor));
  }
  return errors;
}

/// The share of trials with an error up to x.
std::vector<std::pair<double, double>> steps(const std::vector<double>& errors, std::int64_t trials) {
  std::vector<std::pair<double, double>> steps;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const bool last_of_equals = i + 1 == errors.size() || errors[i + 1] > errors[i];
    if (last_of_equals) steps.emplace_back(errors[i], static_cast<double>(i + 1) / static_cast<double>(trials));
  }
  return steps;
}

}  // namespace

std::optional<Figure> error_distribution_figure(const Summary& summary, std::size_t set_index) {
  const SetSummary& set = summary.sets[set_index];
  const std::vector<const Cell*> cells = drawn_cells(summary, set_index);
  std::vector<Curve> curves;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::vector<double> errors = finite_errors(*cells[i]);
    if (errors.empty()) continue;
    curves.push_back({label_of(summary, *cells[i]), i, steps(errors, cells[i]->trials)});
  }
  if (curves.empty()) return std::nullopt;

  ShareAxes axes;
  axes.title = describe(set) + ": distribution of the error";
  axes.alternative = describe(set) + ": share of problems answered within an error." + ends_in_words(curves);
  axes.heading = "Share of all problems answered within an error, of answers said to be solved";
  axes.x_label = set.bare ? "error: backward error" : "error ρ: relative velocity residual";
  axes.tic = power_of_ten;
  axes.bound = verdict_bound(set);
  return Figure{draw_shares(set, axes, curves), axes.alternative, ""};
}

}  // namespace lcpbench::report
