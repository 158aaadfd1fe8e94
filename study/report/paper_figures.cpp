#include "study/report/paper_figures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "study/paper/tables.h"
#include "study/report/axes.h"
#include "study/report/canvas.h"
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

/// Builds an SVG of rectangles and lines of text in pixels, y downward.
class Drawing {
 public:
  Drawing(double width, double height, const std::string& title) {
    svg_ = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:g} {1:g}\" width=\"{0:g}\" height=\"{1:g}\" "
        "font-family=\"Helvetica, Arial, sans-serif\" font-size=\"11\">\n<title>{2}</title>\n",
        width, height, escape(title));
    rectangle({0, 0, width, height}, "#ffffff");
  }

  void rectangle(const Box& box, const std::string& color) {
    svg_ += fmt::format("<path fill=\"{}\" d=\"M{:.5g} {:.5g}h{:.5g}v{:.5g}h{:.5g}z\"/>\n", color, box.left, box.top,
                        box.right - box.left, box.bottom - box.top, box.left - box.right);
  }

  /// One line, centred on `y`.
  void text(double x, double y, const std::string& line, const TextStyle& style) {
    constexpr double kBaseline = 0.36;  // of the size: half the height of capitals
    const char* anchor = style.align == Align::kLeft ? "" : style.align == Align::kCenter ? "middle" : "end";
    svg_ += fmt::format("<text x=\"{:.5g}\" y=\"{:.5g}\" fill=\"{}\"", x, y + kBaseline * style.size, style.color);
    if (*anchor != '\0') svg_ += fmt::format(" text-anchor=\"{}\"", anchor);
    if (style.size != kFieldSize) svg_ += fmt::format(" font-size=\"{:g}\"", style.size);
    if (style.bold) svg_ += " font-weight=\"bold\"";
    svg_ += ">" + escape(line) + "</text>\n";
  }

  std::string finish() { return svg_ + "</svg>\n"; }

 private:
  std::string svg_;
};

void draw_field(Drawing& drawing, const Box& box, const Cell* cell, Measure measure) {
  const double x = (box.left + box.right) / 2;
  const double y = (box.top + box.bottom) / 2;
  const double share = (cell == nullptr ? paper::Proportion{} : paper::solved_share(*cell, measure)).value();
  if (std::isnan(share)) {
    drawing.text(x, y, "–", {.size = kFieldSize, .color = kSoft, .align = Align::kCenter});
    return;
  }
  drawing.rectangle(box, color_of(share));
  const char* ink = share > kLightField ? "#000000" : "#ffffff";
  drawing.text(x, y, field_text(share), {.size = kFieldSize, .color = ink, .align = Align::kCenter});
}

void draw_panel(Drawing& drawing, const ToleranceMap& map, Measure measure, const char* title, double left) {
  const std::size_t columns = map.pivot_tolerances.size();
  const std::size_t rows = map.zero_tolerances.size();
  const double width = kPanelWidth / static_cast<double>(columns);
  const auto column_left = [&](std::size_t column) { return left + static_cast<double>(column) * width; };
  const TextStyle soft{.size = kFieldSize, .color = kSoft, .align = Align::kCenter};
  drawing.text(left, kPanelTop - 18, title, {.size = 13, .color = kInk, .bold = true});
  for (std::size_t zero = 0; zero < rows; ++zero) {
    const double top = kPanelTop + static_cast<double>(rows - 1 - zero) * kRowHeight;
    drawing.text(left - 6, top + kRowHeight / 2, tolerance_text(map.zero_tolerances[zero]),
                 {.size = kFieldSize, .color = kSoft, .align = Align::kRight});
    for (std::size_t pivot = 0; pivot < columns; ++pivot) {
      draw_field(drawing, {column_left(pivot), top, column_left(pivot + 1), top + kRowHeight}, map.at(pivot, zero),
                 measure);
    }
  }
  const double bottom = kPanelTop + static_cast<double>(rows) * kRowHeight;
  for (std::size_t pivot = 0; pivot < columns; ++pivot) {
    drawing.text(column_left(pivot) + width / 2, bottom + 12, tolerance_text(map.pivot_tolerances[pivot]), soft);
  }
  drawing.text(left + kPanelWidth / 2, bottom + 32, "pivot tolerance", soft);
}

void draw_scale(Drawing& drawing, double top) {
  constexpr int kSteps = 50;
  constexpr double kLeft = kFirstPanel + 40;
  constexpr double kStep = 5;
  for (int i = 0; i < kSteps; ++i) {
    drawing.rectangle({kLeft + i * kStep, top, kLeft + (i + 1) * kStep, top + 10}, color_of((i + 0.5) / kSteps));
  }
  drawing.text(kLeft - 6, top + 5, "0 %", {.size = kFieldSize, .color = kSoft, .align = Align::kRight});
  drawing.text(kLeft + kSteps * kStep + 6, top + 5, "100 % solved; rows: zero tolerance",
               {.size = kFieldSize, .color = kSoft});
}

}  // namespace

Figure tolerance_figure(const Summary& summary, const ToleranceMap& map) {
  const SetSummary& set = summary.sets[map.grid->set];
  const double bottom = kPanelTop + static_cast<double>(map.zero_tolerances.size()) * kRowHeight;
  Drawing drawing(kWidth, bottom + 76, set.name + ": share solved over two tolerances");
  drawing.text(kMargin, 22, describe(set), {.size = 17, .color = kInk, .bold = true});
  const std::string line = fmt::format("{} · {} · {} per field", set.name, map.grid->label,
                                       counted(map.grid->cells.front()->trials, "problem"));
  drawing.text(kMargin, 46, shorten(line, 130), {.size = 12, .color = kSoft});
  draw_panel(drawing, map, Measure::kVerdict, "Solved by our verdict [%]", kFirstPanel);
  draw_panel(drawing, map, Measure::kCriterion, "Solved by the paper’s criterion [%]", kSecondPanel);
  draw_scale(drawing, bottom + 54);
  const auto verdict = paper::range_of(*map.grid, Measure::kVerdict);
  const auto criterion = paper::range_of(*map.grid, Measure::kCriterion);
  const std::string alternative = fmt::format(
      "Map of the share solved over pivot and zero tolerance, {}, {}: by our verdict from {} to {} %, by the paper's "
      "criterion from {} to {} %.",
      set.name, map.grid->label, paper::points(verdict.worst.value()), paper::points(verdict.best.value()),
      paper::points(criterion.worst.value()), paper::points(criterion.best.value()));
  return {drawing.finish(), alternative};
}

}  // namespace lcpbench::report
