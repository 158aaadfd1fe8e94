#include "study/report/curves.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "study/report/axes.h"

namespace lcpbench::report {

namespace {

// Dark enough for text on white; neighbours in the list differ in lightness or hue under common colour vision
// deficiencies.
constexpr std::array<const char*, 10> kColors{"#0072b2", "#d55e00", "#007a5a", "#a8518a", "#333333",
                                              "#9a6a00", "#4aa3df", "#7a4fd0", "#5f8a1f", "#8a8a8a"};

double end_pixel(const Curve& curve, const Box& area) { return area.bottom - curve.end() * (area.bottom - area.top); }

struct NamedEnd {
  const Curve* curve = nullptr;
  double label_y = 0;  ///< [px]
};

/// Each label beside its curve's end, as far as ends do not crowd; the highest first.
std::vector<NamedEnd> spread_labels(const std::vector<Curve>& curves, const Box& area) {
  std::vector<NamedEnd> ends;
  for (const Curve& curve : curves) ends.push_back({&curve, 0});
  std::stable_sort(ends.begin(), ends.end(),
                   [](const NamedEnd& a, const NamedEnd& b) { return a.curve->end() > b.curve->end(); });
  std::vector<double> wishes;
  for (const NamedEnd& end : ends) wishes.push_back(end_pixel(*end.curve, area));
  const std::vector<double> placed = stack_labels(wishes, area.top, area.bottom, kLabelHeight);
  for (std::size_t i = 0; i < ends.size(); ++i) ends[i].label_y = placed[i];
  return ends;
}

/// Room that the names need to the right of the axes [px].
double label_room(const std::vector<Curve>& curves) {
  std::size_t longest = 0;
  for (const Curve& curve : curves) longest = std::max(longest, character_count(curve.label));
  return static_cast<double>(longest) * kLabelSize * kMonospaceWidth + 22;
}

std::vector<double> spanned(const ShareAxes& axes, const std::vector<Curve>& curves) {
  std::vector<double> values = axes.x_values;
  if (axes.bound) values.push_back(*axes.bound);
  for (const Curve& curve : curves) {
    for (const auto& [x, share] : curve.steps) values.push_back(x);
  }
  return values;
}

/// gnuplot's inline data, over log10 x.
std::string steps_data(const Curve& curve, const LogAxis& axis) {
  std::string data = fmt::format("{} 0\n", axis.low());
  for (const auto& [x, share] : curve.steps) data += fmt::format("{:.6g} {:.6g}\n", std::log10(x), 100 * share);
  return data + fmt::format("{} {:.6g}\ne\n", axis.high(), 100 * curve.end());
}

/// Names the curves. @returns the plot command with its data.
std::string plot_curves(Canvas& canvas, const std::vector<Curve>& curves, const Box& area, const LogAxis& axis) {
  std::string plot = "plot ";
  std::string data;
  for (const NamedEnd& end : spread_labels(curves, area)) {
    const Curve& curve = *end.curve;
    canvas.line(area.right, end_pixel(curve, area), area.right + 14, end.label_y, curve_color(curve.color), 1);
    canvas.text(area.right + 18, end.label_y, curve.label,
                {.size = kLabelSize, .color = curve_color(curve.color), .monospace = true});
    plot += fmt::format("{}'-' using 1:2 with steps linewidth 1.8 linecolor rgb '{}'", data.empty() ? "" : ", ",
                        curve_color(curve.color));
    data += steps_data(curve, axis);
  }
  return plot + "\n" + data;
}

void draw_bound(Canvas& canvas, double x, const Box& area) {
  canvas.line(x, area.top, x, area.bottom, kWrong, 1, true);
  const bool room_right = area.right - x > 130;
  canvas.text(x + (room_right ? 5 : -5), area.bottom - 10, "not solved beyond this",
              {.size = 11, .color = kWrong, .align = room_right ? Align::kLeft : Align::kRight});
}

}  // namespace

const char* curve_color(std::size_t number) { return kColors[number % kColors.size()]; }

std::string draw_shares(const SetSummary& set, const ShareAxes& axes, const std::vector<Curve>& curves) {
  const double height = std::max(300.0, kLabelHeight * static_cast<double>(curves.size() + 1));
  const Box area{64, 92, kWidth - kMargin - label_room(curves), 92 + height};
  Canvas canvas(kWidth, area.bottom + 56);
  const LogAxis x(spanned(axes, curves), area.left, area.right);
  draw_heading(canvas, set);
  canvas.text(kMargin, area.top - 20, axes.heading, {.color = kSoft});
  draw_frame(canvas, area, fmt::format("[{}:{}]", x.low(), x.high()), x.tics(8, axes.tic), "[0:100]",
             "('0 %%' 0, '25 %%' 25, '50 %%' 50, '75 %%' 75, '100 %%' 100)");
  if (axes.bound) draw_bound(canvas, x.pixel(*axes.bound), area);
  canvas.text((area.left + area.right) / 2, area.bottom + 40, axes.x_label, {.color = kSoft, .align = Align::kCenter});
  const std::string plot = plot_curves(canvas, curves, area, x);
  return canvas.draw(axes.title, plot);
}

}  // namespace lcpbench::report
