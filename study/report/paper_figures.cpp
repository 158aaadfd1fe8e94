#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "study/paper/tables.h"
#include "study/report/axes.h"
#include "study/report/canvas.h"
#include "study/report/figures.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

using paper::Measure;
using paper::ToleranceMap;

struct Color {
  double red;
  double green;
  double blue;
};

// The cividis scale (Nunez, Anderton and Renslow 2018) at quarters: even in lightness, made for deficient colour
// vision.
constexpr std::array<Color, 5> kScale{{{0, 34, 78}, {67, 78, 108}, {125, 124, 120}, {187, 175, 113}, {254, 232, 56}}};
constexpr double kLightField = 0.45;  // above it dark numbers read better than white ones
constexpr double kFieldSize = 11;     // of text
constexpr double kPanelTop = 96;
constexpr double kRowHeight = 30;
constexpr double kPanelWidth = 372;
constexpr double kFirstPanel = 66;
constexpr double kSecondPanel = 510;

std::string color_of(double share) {
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(kScale.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(place), kScale.size() - 2);
  const double part = place - static_cast<double>(below);
  const auto blend = [&](double Color::*channel) {
    return static_cast<int>(std::lround(kScale[below].*channel * (1 - part) + kScale[below + 1].*channel * part));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", blend(&Color::red), blend(&Color::green), blend(&Color::blue));
}

/// "99.8", short enough for a field; 100 and 0 only when exactly that.
std::string field_text(double share) {
  const double value = 100 * share;
  if (value == 0 || value == 100) return fmt::format("{:.0f}", value);
  return fmt::format("{:.1f}", std::clamp(value, 0.1, 99.9));
}

std::string tolerance_text(double tolerance) {
  if (!(tolerance > 0)) return fmt::format("{:g}", tolerance);
  const double exponent = std::log10(tolerance);
  const bool whole = std::abs(exponent - std::round(exponent)) < 1e-9;
  return whole ? power_of_ten(static_cast<int>(std::lround(exponent))) : fmt::format("{:.2g}", tolerance);
}

void draw_field(Canvas& canvas, const Box& box, const Cell* cell, Measure measure) {
  const double x = (box.left + box.right) / 2;
  const double y = (box.top + box.bottom) / 2;
  const double share = (cell == nullptr ? paper::Proportion{} : paper::solved_share(*cell, measure)).value();
  if (std::isnan(share)) {
    canvas.text(x, y, "–", {.size = kFieldSize, .color = kSoft, .align = Align::kCenter});
    return;
  }
  canvas.rectangle(box, color_of(share));
  const char* ink = share > kLightField ? "#000000" : "#ffffff";
  canvas.text(x, y, field_text(share), {.size = kFieldSize, .color = ink, .align = Align::kCenter});
}

void draw_panel(Canvas& canvas, const ToleranceMap& map, Measure measure, const char* title, double left) {
  const std::size_t columns = map.pivot_tolerances.size();
  const std::size_t rows = map.zero_tolerances.size();
  const double width = kPanelWidth / static_cast<double>(columns);
  const auto column_left = [&](std::size_t column) { return left + static_cast<double>(column) * width; };
  const TextStyle soft{.size = kFieldSize, .color = kSoft, .align = Align::kCenter};
  canvas.text(left, kPanelTop - 18, title, {.size = 13, .bold = true});
  for (std::size_t zero = 0; zero < rows; ++zero) {
    const double top = kPanelTop + static_cast<double>(rows - 1 - zero) * kRowHeight;
    canvas.text(left - 6, top + kRowHeight / 2, tolerance_text(map.zero_tolerances[zero]),
                {.size = kFieldSize, .color = kSoft, .align = Align::kRight});
    for (std::size_t pivot = 0; pivot < columns; ++pivot) {
      draw_field(canvas, {column_left(pivot), top, column_left(pivot + 1), top + kRowHeight}, map.at(pivot, zero),
                 measure);
    }
  }
  const double bottom = kPanelTop + static_cast<double>(rows) * kRowHeight;
  for (std::size_t pivot = 0; pivot < columns; ++pivot) {
    canvas.text(column_left(pivot) + width / 2, bottom + 12, tolerance_text(map.pivot_tolerances[pivot]), soft);
  }
  canvas.text(left + kPanelWidth / 2, bottom + 32, "pivot tolerance", soft);
}

void draw_scale(Canvas& canvas, double top) {
  constexpr int kSteps = 50;
  constexpr double kLeft = kFirstPanel + 40;
  constexpr double kStep = 5;
  for (int i = 0; i < kSteps; ++i) {
    canvas.rectangle({kLeft + i * kStep, top, kLeft + (i + 1) * kStep, top + 10}, color_of((i + 0.5) / kSteps));
  }
  canvas.text(kLeft - 6, top + 5, "0 %", {.size = kFieldSize, .color = kSoft, .align = Align::kRight});
  canvas.text(kLeft + kSteps * kStep + 6, top + 5, "100 % solved; rows: zero tolerance",
              {.size = kFieldSize, .color = kSoft});
}

}  // namespace

Figure tolerance_figure(const Summary& summary, const ToleranceMap& map) {
  const SetSummary& set = summary.sets[map.grid->set];
  const double bottom = kPanelTop + static_cast<double>(map.zero_tolerances.size()) * kRowHeight;
  Canvas canvas(kWidth, bottom + 76);
  canvas.text(kMargin, 22, describe(set), {.size = 17, .bold = true});
  const std::string line = fmt::format("{} · {} · {} per field", set.name, map.grid->label,
                                       counted(map.grid->cells.front()->trials, "problem"));
  canvas.text(kMargin, 46, shorten(line, 130), {.size = 12, .color = kSoft});
  draw_panel(canvas, map, Measure::kVerdict, "Solved by our verdict [%]", kFirstPanel);
  draw_panel(canvas, map, Measure::kCriterion, "Solved by the paper’s criterion [%]", kSecondPanel);
  draw_scale(canvas, bottom + 54);
  const auto verdict = paper::range_of(*map.grid, Measure::kVerdict);
  const auto criterion = paper::range_of(*map.grid, Measure::kCriterion);
  const std::string alternative = fmt::format(
      "Map of the share solved over pivot and zero tolerance, {}, {}: by our verdict from {} to {} %, by the paper's "
      "criterion from {} to {} %.",
      set.name, map.grid->label, paper::points(verdict.worst.value()), paper::points(verdict.best.value()),
      paper::points(criterion.worst.value()), paper::points(criterion.best.value()));
  return {canvas.draw(set.name + ": share solved over two tolerances", alternative), alternative, ""};
}

}  // namespace lcpbench::report
