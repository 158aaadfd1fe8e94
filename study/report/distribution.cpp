#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "study/report/axes.h"
#include "study/report/figures.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

// Dark enough for text on white; neighbours in the list differ in lightness or hue under common colour vision
// deficiencies.
constexpr std::array<const char*, 10> kColors{"#0072b2", "#d55e00", "#007a5a", "#a8518a", "#333333",
                                              "#9a6a00", "#4aa3df", "#7a4fd0", "#5f8a1f", "#8a8a8a"};

struct Curve {
  const Cell* cell = nullptr;
  std::string label;
  const char* color = nullptr;
  double end = 0;      ///< share answered at all with a finite error
  double label_y = 0;  ///< [px]
};

/// Finite errors, clamped to what the axis shows.
std::vector<double> finite_errors(const Cell& cell) {
  std::vector<double> errors;
  for (const double error : cell.errors) {
    if (std::isfinite(error)) errors.push_back(std::max(error, kErrorFloor));
  }
  return errors;
}

/// Steps of the share of trials with an error up to x, as gnuplot's inline data over log10 x.
std::string steps(const Cell& cell, const LogAxis& x) {
  const std::vector<double> errors = finite_errors(cell);
  const auto trials = static_cast<double>(cell.trials);
  std::string data = fmt::format("{} 0\n", x.low());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const bool last_of_equals = i + 1 == errors.size() || errors[i + 1] > errors[i];
    if (last_of_equals) {
      data += fmt::format("{:.6g} {:.6g}\n", std::log10(errors[i]), 100 * static_cast<double>(i + 1) / trials);
    }
  }
  return data + fmt::format("{} {:.6g}\ne\n", x.high(), 100 * static_cast<double>(errors.size()) / trials);
}

/// Puts each label beside its curve's end, and where ends crowd, pushes labels down, then up again from the bottom,
/// until no two overlap.
void spread_labels(std::vector<Curve>& curves, const Box& area) {
  std::sort(curves.begin(), curves.end(), [](const Curve& a, const Curve& b) { return a.end > b.end; });
  double y = area.top - kLabelHeight;
  for (Curve& curve : curves) {
    const double wanted = area.bottom - curve.end * (area.bottom - area.top);
    y = std::max(wanted, y + kLabelHeight);
    curve.label_y = y;
  }
  double limit = area.bottom;
  for (auto curve = curves.rbegin(); curve != curves.rend(); ++curve) {
    curve->label_y = std::min(curve->label_y, limit);
    limit = curve->label_y - kLabelHeight;
  }
}

std::vector<Curve> curves_of(const Summary& summary, const std::vector<const Cell*>& cells) {
  std::vector<Curve> curves;
  for (const Cell* cell : cells) {
    const std::vector<double> errors = finite_errors(*cell);
    if (errors.empty()) continue;
    const double end = static_cast<double>(errors.size()) / static_cast<double>(cell->trials);
    curves.push_back({cell, label_of(summary, *cell), kColors[curves.size() % kColors.size()], end, 0});
  }
  return curves;
}

void draw_labels(Canvas& canvas, const std::vector<Curve>& curves, const Box& area) {
  for (const Curve& curve : curves) {
    const double end_y = area.bottom - curve.end * (area.bottom - area.top);
    canvas.line(area.right, end_y, area.right + 14, curve.label_y, curve.color, 1);
    canvas.text(area.right + 18, curve.label_y, curve.label,
                {.size = kLabelSize, .color = curve.color, .monospace = true});
  }
}

}  // namespace

std::optional<Figure> error_distribution_figure(const Summary& summary, std::size_t set_index) {
  const SetSummary& set = summary.sets[set_index];
  std::vector<Curve> curves = curves_of(summary, drawn_cells(summary, set_index));
  if (curves.empty()) return std::nullopt;

  std::size_t longest = 0;
  std::vector<double> all{verdict_bound(set)};
  for (const Curve& curve : curves) {
    longest = std::max(longest, character_count(curve.label));
    const std::vector<double> errors = finite_errors(*curve.cell);
    all.insert(all.end(), errors.begin(), errors.end());
  }
  const double labels = static_cast<double>(longest) * kLabelSize * kMonospaceWidth + 22;
  const double height = std::max(300.0, kLabelHeight * static_cast<double>(curves.size() + 1));
  const Box area{64, 92, kWidth - kMargin - labels, 92 + height};
  Canvas canvas(kWidth, area.bottom + 56);
  const LogAxis x(all, area.left, area.right);
  draw_heading(canvas, set);
  canvas.text(kMargin, area.top - 20, "Share of all problems answered within an error, of answers said to be solved",
              {.color = kSoft});
  draw_frame(canvas, area, fmt::format("[{}:{}]", x.low(), x.high()), x.tics(8, power_of_ten), "[0:100]",
             "('0 %%' 0, '25 %%' 25, '50 %%' 50, '75 %%' 75, '100 %%' 100)");
  const double bound_x = x.pixel(verdict_bound(set));
  canvas.line(bound_x, area.top, bound_x, area.bottom, kWrong, 1, true);
  const bool room_right = area.right - bound_x > 130;
  canvas.text(bound_x + (room_right ? 5 : -5), area.bottom - 10, "wrong beyond this",
              {.size = 11, .color = kWrong, .align = room_right ? Align::kLeft : Align::kRight});
  canvas.text((area.left + area.right) / 2, area.bottom + 40,
              set.bare ? "error: backward error" : "error ρ: relative velocity residual",
              {.color = kSoft, .align = Align::kCenter});
  spread_labels(curves, area);
  draw_labels(canvas, curves, area);

  std::string plot = "plot ";
  std::string data;
  for (const Curve& curve : curves) {
    plot += fmt::format("{}'-' using 1:2 with steps linewidth 1.8 linecolor rgb '{}'", data.empty() ? "" : ", ",
                        curve.color);
    data += steps(*curve.cell, x);
  }
  std::string alternative = describe(set) + ": share of problems answered within an error.";
  for (const Curve& curve : curves) {
    alternative += fmt::format(" {}: median {}, 99th percentile {}.", curve.label, scientific(curve.cell->error_median),
                               scientific(curve.cell->error_p99));
  }
  return Figure{canvas.draw(escape(describe(set) + ": distribution of the error"), plot + "\n" + data), alternative};
}

}  // namespace lcpbench::report
