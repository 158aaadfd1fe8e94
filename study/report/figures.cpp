#include "study/report/figures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "study/report/axes.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

constexpr double kRowHeight = 21;
constexpr double kErrorCeiling = 100;  // larger errors are drawn here, their value in the label
constexpr const char* kPoint = "#1f5a99";
constexpr const char* kWhisker = "#9db8d6";
constexpr const char* kLoose = "#d98e04";
constexpr const char* kGaveUp = "#8a8a8a";

struct Shares {
  double wrong = 0;
  double loose = 0;
  double gave_up = 0;
};

Shares shares_of(const Cell& cell) {
  const auto of_trials = [&cell](std::int64_t count) {
    return static_cast<double>(count) / static_cast<double>(cell.trials);
  };
  return {of_trials(cell.false_claims()), of_trials(cell.count(Claim::kSolved, Verdict::kCriterionOnly)),
          of_trials(cell.gave_up())};
}

/// One column of bars in the strip, with its heading.
struct StripColumn {
  const char* heading;
  const char* color;
  double Shares::*share;
};

void draw_bar(Canvas& canvas, double left, double y, double full_width, double share, const char* color) {
  const double width = std::max(share > 0 ? 1.5 : 0.0, share * full_width);
  canvas.line(left, y - 8, left, y + 8, "#bbbbbb", 1);
  if (width > 0) canvas.rectangle({left, y - 7, left + width, y + 7}, color);
  canvas.text(left + width + 5, y, percent(share),
              {.size = kLabelSize, .color = share > 0 ? kInk : kSoft, .bold = share > 0});
}

/// The strip; returns the y below it.
double draw_strip(Canvas& canvas, const Summary& summary, std::vector<const Cell*> cells, double top) {
  std::stable_sort(cells.begin(), cells.end(), [](const Cell* a, const Cell* b) {
    const Shares left = shares_of(*a);
    const Shares right = shares_of(*b);
    return std::pair(left.wrong, left.gave_up + left.loose) < std::pair(right.wrong, right.gave_up + right.loose);
  });
  std::vector<StripColumn> columns{{"said solved, was wrong", kWrong, &Shares::wrong}};
  const bool loose =
      std::any_of(cells.begin(), cells.end(), [](const Cell* cell) { return shares_of(*cell).loose > 0; });
  if (loose) columns.push_back({"said solved, only roughly right", kLoose, &Shares::loose});
  columns.push_back({"gave up", kGaveUp, &Shares::gave_up});

  std::size_t longest = 0;
  for (const Cell* cell : cells) longest = std::max(longest, character_count(label_of(summary, *cell)));
  const double names_end = kMargin + static_cast<double>(longest) * kLabelSize * kMonospaceWidth + 4;
  const double column_width = (kWidth - names_end - kMargin) / static_cast<double>(columns.size());
  const double bar_width = column_width - 75;
  for (std::size_t column = 0; column < columns.size(); ++column) {
    const double left = names_end + 10 + static_cast<double>(column) * column_width;
    canvas.text(left, top + 8, columns[column].heading, {.color = columns[column].color, .bold = true});
    double y = top + 30;
    for (const Cell* cell : cells) {
      draw_bar(canvas, left, y, bar_width, shares_of(*cell).*columns[column].share, columns[column].color);
      y += kRowHeight;
    }
  }
  double y = top + 30;
  for (const Cell* cell : cells) {
    canvas.text(names_end, y, label_of(summary, *cell), {.align = Align::kRight, .monospace = true});
    y += kRowHeight;
  }
  return y;
}

/// What a point shows: the cell, with an error that fits on the axis.
struct DrawnPoint {
  const Cell* cell = nullptr;
  std::string label;
  double time_s = 0;
  double error = 0;
  double median_error = 0;
};

std::vector<DrawnPoint> points_of(const Summary& summary, const std::vector<const Cell*>& cells) {
  std::vector<DrawnPoint> points;
  for (const Cell* cell : cells) {
    if (std::isnan(cell->error_p99) || !(cell->median_time.value > 0)) continue;
    DrawnPoint point{cell, label_of(summary, *cell), cell->median_time.value, 0, 0};
    point.error = std::clamp(cell->error_p99, kErrorFloor, kErrorCeiling);
    point.median_error = std::clamp(cell->error_median, kErrorFloor, kErrorCeiling);
    if (cell->error_p99 > kErrorCeiling) point.label += ": " + scientific(cell->error_p99);
    points.push_back(std::move(point));
  }
  return points;
}

std::string undrawn_note(const Summary& summary, const std::vector<const Cell*>& cells) {
  std::string names;
  for (const Cell* cell : cells) {
    if (!std::isnan(cell->error_p99)) continue;
    names += (names.empty() ? "" : ", ") + summary.solvers[cell->solver].text();
  }
  return names.empty() ? "" : shorten("No point, as it never said solved: " + names, 125);
}

/// The points with their labels, clear of each other and of the line of the verdict.
std::string draw_points(Canvas& canvas, const std::vector<DrawnPoint>& points, const Box& area, const LogAxis& x,
                        const LogAxis& y, std::vector<Box> obstacles) {
  std::vector<LabelledPoint> wishes;
  std::string data;
  for (const DrawnPoint& point : points) {
    const double px = x.pixel(point.time_s);
    const double py = y.pixel(point.error);
    const double median_y = y.pixel(point.median_error);
    wishes.push_back({px, py, static_cast<double>(character_count(point.label)) * kLabelSize * kMonospaceWidth + 4});
    obstacles.push_back({px - 2, std::min(py, median_y), px + 2, std::max(py, median_y)});
    canvas.line(px, py, px, median_y, kWhisker, 2, false, Layer::kBack);
    canvas.line(px - 4, median_y, px + 4, median_y, kWhisker, 2, false, Layer::kBack);
    data += fmt::format("{:.9g} {:.9g}\n", std::log10(point.time_s), std::log10(point.error));
  }
  const std::vector<PlacedLabel> placed = place_labels(wishes, obstacles, area, kLabelHeight);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Box& box = placed[i].box;
    const double middle = (box.top + box.bottom) / 2;
    if (placed[i].leader) {
      canvas.line(wishes[i].x, wishes[i].y, std::clamp(wishes[i].x, box.left, box.right),
                  std::clamp(wishes[i].y, box.top + 2, box.bottom - 2), "#888888", 0.8);
    }
    canvas.text(box.left + 2, middle, points[i].label, {.size = kLabelSize, .color = kInk, .monospace = true});
  }
  return fmt::format("plot '-' using 1:2 with points pointtype 7 pointsize 0.9 linecolor rgb '{}'\n{}e", kPoint, data);
}

std::string alternative_text(const Summary& summary, const SetSummary& set, const std::vector<const Cell*>& cells) {
  std::string text = describe(set) + ": time per problem against error.";
  for (const Cell* cell : cells) {
    text +=
        fmt::format(" {}: median {}, 99th percentile of the error {}, said solved and was wrong {}, gave up {}.",
                    summary.solvers[cell->solver].text(), duration(cell->median_time.value),
                    scientific(cell->error_p99), percent(shares_of(*cell).wrong), percent(shares_of(*cell).gave_up));
  }
  return text;
}

}  // namespace

std::vector<const Cell*> drawn_cells(const Summary& summary, std::size_t set) {
  std::vector<const Cell*> cells;
  for (const Cell& cell : summary.cells) {
    if (cell.set == set && summary.solvers[cell.solver].sweep.empty() && !cell.refused()) cells.push_back(&cell);
  }
  return cells;
}

std::optional<Figure> speed_error_figure(const Summary& summary, std::size_t set_index) {
  const SetSummary& set = summary.sets[set_index];
  const std::vector<const Cell*> cells = drawn_cells(summary, set_index);
  const std::vector<DrawnPoint> points = points_of(summary, cells);
  if (points.empty()) return std::nullopt;

  const double strip_bottom = 60 + 30 + kRowHeight * static_cast<double>(cells.size());
  const Box area{84, strip_bottom + 42, kWidth - 2 * kMargin, strip_bottom + 42 + 380};
  const std::string note = undrawn_note(summary, cells);
  Canvas canvas(kWidth, area.bottom + 56 + (note.empty() ? 0 : 18));
  draw_heading(canvas, set);
  draw_strip(canvas, summary, cells, 60);

  std::vector<double> times;
  std::vector<double> errors{verdict_bound(set) * 10};
  for (const DrawnPoint& point : points) {
    times.push_back(point.time_s);
    errors.push_back(point.error);
    errors.push_back(point.median_error);
  }
  const LogAxis x(times, area.left, area.right);
  const LogAxis y(errors, area.bottom, area.top);
  draw_frame(canvas, area, fmt::format("[{}:{}]", x.low(), x.high()), x.tics(9, time_of_decade),
             fmt::format("[{}:{}]", y.low(), y.high()), y.tics(9, power_of_ten));
  const double bound_y = y.pixel(verdict_bound(set));
  canvas.line(area.left, bound_y, area.right, bound_y, kWrong, 1, true);
  const std::string bound_text =
      set.bare ? "above 10⁻⁹ an answer counts as wrong" : "above 10⁻⁴ an answer counts as wrong";
  const double bound_width = static_cast<double>(character_count(bound_text)) * 11 * kProportionalWidth;
  canvas.text(area.right, bound_y - 9, bound_text, {.size = 11, .color = kWrong, .align = Align::kRight});

  canvas.text(
      kMargin, area.top - 20,
      set.bare ? "Error: backward error of the answers said to be solved; dot 99th percentile, bar down to the median"
               : "Error ρ: relative velocity residual of the answers said to be solved; dot 99th percentile, bar "
                 "down to the median",
      {.color = kSoft});
  canvas.text((area.left + area.right) / 2, area.bottom + 40,
              "← faster    median time per problem, set-up and solve (CPU)    slower →",
              {.color = kSoft, .align = Align::kCenter});
  canvas.text(kMargin, area.bottom + 60, note, {.size = 11, .color = kSoft});
  const std::vector<Box> obstacles{{area.left, bound_y - 2, area.right, bound_y + 2},
                                   {area.right - bound_width, bound_y - 18, area.right, bound_y}};
  const std::string plot = draw_points(canvas, points, area, x, y, obstacles);
  const std::string alternative = alternative_text(summary, set, cells);
  return Figure{canvas.draw(escape(describe(set) + ": speed against error"), plot), alternative};
}

}  // namespace lcpbench::report
