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

std::string sized_label(const Summary& summary, const Cell& cell, std::string label) {
  if (cell.trials < summary.sets[cell.set].problems)
    label += fmt::format(" ({} of {})", cell.trials, summary.sets[cell.set].problems);
  return shorten(label, 44);
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

std::string label_of(const Summary& summary, const Cell& cell) {
  return sized_label(summary, cell, summary.solvers[cell.solver].text());
}

std::string rung_label(const Summary& summary, const Cell& cell) {
  return sized_label(summary, cell, rung_label(summary, cell.solver));
}

double verdict_bound(const SetSummary& set) { return set.bare ? 1e-9 : 1e-4; }

}  // namespace lcpbench::report
