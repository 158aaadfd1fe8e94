#include "study/report/axes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

#include "study/report/speed_error.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

std::string superscript(int value) {
  constexpr std::array<const char*, 10> kDigits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string out = value < 0 ? "⁻" : "";
  for (const char digit : std::to_string(std::abs(value))) out += kDigits[static_cast<std::size_t>(digit - '0')];
  return out;
}

std::string set_line(const SetSummary& set) {
  const std::string size = set.smallest_n == set.largest_n ? fmt::format("n = {}", set.largest_n)
                                                           : fmt::format("n = {}–{}", set.smallest_n, set.largest_n);
  return shorten(fmt::format("{} · {} · {}", set.name, counted(set.problems, "problem"), size), 120);
}

constexpr std::array kColors{"c0", "c1", "c2", "c3", "c4", "c5", "c6", "c7", "c8", "c9"};
constexpr double kSample = 26;   // of a curve's line, before its name [px]
constexpr double kFinest = 0.7;  // [px]

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

/// Room that the lines' samples and the names need to the right of the axes [px].
double label_room(const std::vector<Curve>& curves) {
  std::size_t longest = 0;
  for (const Curve& curve : curves) longest = std::max(longest, character_count(curve.label));
  return static_cast<double>(longest) * kLabelSize * kMonospaceWidth + kSample + 22;
}

std::vector<double> spanned(const ShareAxes& axes, const std::vector<Curve>& curves) {
  std::vector<double> values;
  if (axes.bound) values.push_back(*axes.bound);
  for (const Curve& curve : curves) {
    for (const auto& [x, share] : curve.steps) values.push_back(x);
  }
  return values;
}

void draw_curves(Canvas& canvas, const std::vector<Curve>& curves, const Box& area, const LogAxis& axis) {
  const auto height = [&area](double share) { return area.bottom - share * (area.bottom - area.top); };
  for (const NamedEnd& end : spread_labels(curves, area)) {
    const Curve& curve = *end.curve;
    std::vector<std::pair<double, double>> pixels{{area.left, area.bottom}};
    for (const auto& [x, share] : curve.steps) {
      // Of steps that the eye cannot tell apart one is drawn, so that a picture of 20,000 problems is no larger.
      const bool same_place = pixels.size() > 1 && axis.pixel(x) - pixels.back().first < kFinest;
      if (!same_place) pixels.emplace_back(axis.pixel(x), height(share));
      pixels.back().second = height(share);
    }
    pixels.emplace_back(area.right, height(curve.end()));
    const double sample = area.right + 16;
    canvas.steps(pixels, curve_stroke(curve.color, 1.8));
    canvas.line(area.right, height(curve.end()), sample - 3, end.label_y, kAxis, 0.7);
    canvas.steps({{sample, end.label_y}, {sample + kSample, end.label_y}}, curve_stroke(curve.color, 1.8));
    canvas.text(sample + kSample + 4, end.label_y, curve.label,
                {.size = kLabelSize, .color = curve_color(curve.color), .monospace = true});
  }
}

void draw_bound(Canvas& canvas, double x, const Box& area) {
  canvas.line(x, area.top, x, area.bottom, kWrong, 1, true);
  const bool room_right = area.right - x > 130;
  canvas.text(x + (room_right ? 5 : -5), area.bottom - 10, "not solved beyond this",
              {.size = 11, .color = kWrong, .align = room_right ? Align::kLeft : Align::kRight});
}

}  // namespace

std::string power_of_ten(int exponent) { return exponent == 0 ? "1" : "10" + superscript(exponent); }

std::string time_of_decade(int exponent) {
  constexpr std::array<const char*, 4> kUnits{"ns", "µs", "ms", "s"};
  const int unit = std::clamp((exponent + 9) / 3, 0, 3);
  const int power = exponent + 9 - 3 * unit;
  const char* name = kUnits[static_cast<std::size_t>(unit)];
  if (power > 2) return "10" + superscript(power) + " " + name;
  return fmt::format("{:.0f} {}", std::pow(10, power), name);
}

std::string ratio_of_decade(int exponent) {
  if (exponent == 0) return "same";
  const int magnitude = std::abs(exponent);
  const std::string size = magnitude <= 3 ? fmt::format("{:.0f}", std::pow(10, magnitude)) : power_of_ten(magnitude);
  return exponent < 0 ? "1/" + size : size + "×";
}

LogAxis::LogAxis(const std::vector<double>& values, double begin, double end) : begin_(begin), end_(end) {
  const auto [smallest, largest] = std::minmax_element(values.begin(), values.end());
  const double low = std::log10(*smallest);
  const double high = std::log10(*largest);
  // A point on the frame would be half hidden: keep a fiftieth of the axis, about a point's size, free at either end.
  const double margin = 0.02 * (high - low + 1);
  low_ = static_cast<int>(std::floor(low - margin));
  high_ = static_cast<int>(std::ceil(high + margin));
}

double LogAxis::pixel(double value) const {
  return begin_ + (std::log10(value) - low_) / (high_ - low_) * (end_ - begin_);
}

std::vector<Tic> LogAxis::tics(int count, std::string (*name)(int)) const {
  const int step = std::max(1, (high_ - low_ + count - 1) / count);
  std::vector<Tic> tics;
  for (int exponent = low_; exponent <= high_; ++exponent) {
    if (exponent % step == 0) tics.push_back({pixel(std::pow(10, exponent)), name(exponent)});
  }
  return tics;
}

void draw_frame(Canvas& canvas, const Box& area, const std::vector<Tic>& x_tics, const std::vector<Tic>& y_tics) {
  for (const Tic& tic : x_tics) {
    canvas.line(tic.pixel, area.top, tic.pixel, area.bottom, kGrid, 1, false, Layer::kBack);
    canvas.text(tic.pixel, area.bottom + 14, tic.label, {.align = Align::kCenter});
  }
  for (const Tic& tic : y_tics) {
    canvas.line(area.left, tic.pixel, area.right, tic.pixel, kGrid, 1, false, Layer::kBack);
    canvas.text(area.left - 6, tic.pixel, tic.label, {.align = Align::kRight});
  }
  canvas.line(area.left, area.top, area.left, area.bottom, kAxis, 1);
  canvas.line(area.left, area.bottom, area.right, area.bottom, kAxis, 1);
}

void draw_heading(Canvas& canvas, const SetSummary& set) {
  canvas.text(kMargin, 22, describe(set), {.size = 17, .bold = true});
  canvas.text(kMargin, 44, set_line(set), {.color = kSoft});
}

std::string sized_label(const std::string& label, std::int64_t trials, std::int64_t problems) {
  return shorten(trials < problems ? fmt::format("{} ({} of {})", label, trials, problems) : label, 44);
}

std::string rung_label(const Summary& summary, const Cell& cell) {
  return sized_label(rung_label(summary, cell.solver), cell.trials, summary.sets[cell.set].problems);
}

double verdict_bound(const SetSummary& set) { return set.bare ? 1e-9 : 1e-4; }

const char* curve_color(std::size_t number) { return kColors[number % kColors.size()]; }

Stroke curve_stroke(std::size_t number, double width) {
  Stroke stroke{curve_color(number), width, ""};
  const std::size_t turn = number / kColors.size();
  if (turn == 1) stroke.dash = "7 3";
  if (turn == 2) stroke.dash = "2 2";
  if (turn > 2) stroke.dash = fmt::format("{} 3 2 3", 5 * turn - 6);
  return stroke;
}

std::string ends_in_words(const std::vector<Curve>& curves) {
  std::string words;
  for (const Curve& curve : curves) words += fmt::format(" {}: {} in the end.", curve.label, percent(curve.end()));
  return words;
}

std::string draw_shares(const SetSummary& set, const ShareAxes& axes, const std::vector<Curve>& curves) {
  const double height = std::max(300.0, kLabelHeight * static_cast<double>(curves.size() + 1));
  const Box area{64, 92, kWidth - kMargin - label_room(curves), 92 + height};
  Canvas canvas(kWidth, area.bottom + 56);
  const LogAxis x(spanned(axes, curves), area.left, area.right);
  draw_heading(canvas, set);
  canvas.text(kMargin, area.top - 20, axes.heading, {.color = kSoft});
  std::vector<Tic> shares;
  for (const int part : {0, 25, 50, 75, 100}) {
    shares.push_back({area.bottom - 0.01 * part * (area.bottom - area.top), fmt::format("{} %", part)});
  }
  draw_frame(canvas, area, x.tics(8, axes.tic), shares);
  if (axes.bound) draw_bound(canvas, x.pixel(*axes.bound), area);
  canvas.text((area.left + area.right) / 2, area.bottom + 40, axes.x_label, {.color = kSoft, .align = Align::kCenter});
  draw_curves(canvas, curves, area, x);
  return canvas.draw(axes.title, axes.alternative);
}

}  // namespace lcpbench::report
