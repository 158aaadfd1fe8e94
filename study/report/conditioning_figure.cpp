#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "study/report/axes.h"
#include "study/report/curves.h"
#include "study/report/figures.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

constexpr double kErrorCeiling = 1e2;  // larger errors are drawn here
constexpr double kPanelHeight = 250;
constexpr double kGap = 92;

/// One solver along the dial; value is what the panel shows.
struct Line {
  struct Point {
    double condition = 0;
    double value = 0;
    bool reliable = false;
  };
  std::string label;
  std::size_t color = 0;
  std::vector<Point> points;  ///< ascending by condition
  bool reaches_the_end = false;
};

std::vector<Line> lines_of(const Summary& summary, const Conditioning& family,
                           double (*value)(const SpeedErrorPoint&)) {
  std::vector<Line> lines;
  for (std::size_t i = 0; i < family.solvers.size(); ++i) {
    Line line{shorten(rung_label(summary, family.solvers[i]), 34), i, {}};
    for (std::size_t step = 0; step < family.steps.size(); ++step) {
      for (const SpeedErrorPoint& point : family.steps[step].points) {
        if (point.cell->solver != family.solvers[i] || !point.placed()) continue;
        line.points.push_back({family.conditions[step], value(point), point.reliable()});
      }
    }
    line.reaches_the_end = line.points.back().condition == family.conditions.back();
    lines.push_back(std::move(line));
  }
  return lines;
}

double drawn_error(const SpeedErrorPoint& point) { return std::clamp(point.p99, kErrorFloor, kErrorCeiling); }
double cost(const SpeedErrorPoint& point) { return point.cost.value; }

/// What a panel says around its lines.
struct Panel {
  std::string heading;
  std::string (*tic)(int) = nullptr;
  std::optional<double> bound;
};

/// A gnuplot picture holds one plot of data; these few segments are drawn as a part of the canvas instead.
void draw_panel(Canvas& canvas, const Box& area, const std::vector<Line>& lines, const LogAxis& x, const Panel& panel) {
  std::vector<double> values;
  if (panel.bound) values.push_back(*panel.bound);
  for (const Line& line : lines) {
    for (const Line::Point& point : line.points) values.push_back(point.value);
  }
  const LogAxis y(values, area.bottom, area.top);
  canvas.text(kMargin, area.top - 18, panel.heading, {.color = kSoft});
  const int step = std::max(1, (y.high() - y.low() + 7) / 8);
  for (int exponent = y.low(); exponent <= y.high(); ++exponent) {
    if (exponent % step != 0) continue;
    const double at = y.pixel(std::pow(10, exponent));
    canvas.line(area.left, at, area.right, at, kGrid, 1, false, Layer::kBack);
    canvas.text(area.left - 6, at, panel.tic(exponent), {.color = kInk, .align = Align::kRight});
  }
  if (panel.bound) {
    const double at = y.pixel(*panel.bound);
    canvas.line(area.left, at, area.right, at, kWrong, 1, true);
    canvas.text(area.left + 4, at - 9, "not solved above this", {.size = 11, .color = kWrong});
  }
  canvas.line(area.left, area.top, area.left, area.bottom, "#999999", 1);
  canvas.line(area.left, area.bottom, area.right, area.bottom, "#999999", 1);
  std::vector<double> ends;
  for (const Line& line : lines) ends.push_back(y.pixel(line.points.back().value));
  const std::vector<double> labels = stack_labels(ends, area.top, area.bottom + 12, kLabelHeight - 1);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const char* color = curve_color(lines[i].color);
    const auto& points = lines[i].points;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double px = x.pixel(points[k].condition);
      const double py = y.pixel(points[k].value);
      const double half = points[k].reliable ? 3 : 1.5;
      canvas.rectangle({px - half, py - half, px + half, py + half}, color);
      if (k == 0) continue;
      const bool reliable = points[k].reliable && points[k - 1].reliable;
      canvas.line(x.pixel(points[k - 1].condition), y.pixel(points[k - 1].value), px, py, color, reliable ? 1.6 : 0.9,
                  !reliable);
    }
    const double end = x.pixel(points.back().condition);
    const bool to_the_last = lines[i].reaches_the_end;
    canvas.line(end + 3, ends[i], area.right + 14, labels[i], to_the_last ? color : "#bbbbbb", to_the_last ? 0.7 : 0.5,
                false, Layer::kBack);
    canvas.text(area.right + 18, labels[i], lines[i].label, {.size = kLabelSize, .color = color, .monospace = true});
  }
}

std::string alternative_text(const Summary& summary, const Conditioning& family) {
  std::string text = family.family + ": " + measure_words(family.measure) + ", 99th percentile, by condition number.";
  for (const Line& line : lines_of(summary, family, drawn_error)) {
    text += " " + line.label + ":";
    for (const Line::Point& point : line.points) {
      text += fmt::format(" {} at {},", scientific(point.value), condition_text(point.condition));
    }
    text.back() = '.';
  }
  return text;
}

bool reaches_floor(const std::vector<Line>& errors) {
  return std::any_of(errors.begin(), errors.end(), [](const Line& line) {
    return std::any_of(line.points.begin(), line.points.end(),
                       [](const Line::Point& point) { return point.value <= kErrorFloor; });
  });
}

double label_room(const std::vector<Line>& lines) {
  std::size_t longest = 0;
  for (const Line& line : lines) longest = std::max(longest, character_count(line.label));
  return static_cast<double>(longest) * kLabelSize * kMonospaceWidth + 22;
}

}  // namespace

std::optional<Figure> conditioning_figure(const Summary& summary, const Conditioning& family) {
  if (family.solvers.empty()) return std::nullopt;
  const std::vector<Line> errors = lines_of(summary, family, drawn_error);
  const std::vector<Line> costs = lines_of(summary, family, cost);
  const bool relative = family.steps.front().relative;
  const double height = std::max(kPanelHeight, (kLabelHeight - 1) * static_cast<double>(errors.size() + 1));
  const Box top{76, 92, kWidth - kMargin - label_room(errors), 92 + height};
  const Box bottom{top.left, top.bottom + kGap, top.right, top.bottom + kGap + height};
  Canvas canvas(kWidth, bottom.bottom + 60);
  SetSummary set = summary.sets[family.steps.front().set];
  canvas.text(
      kMargin, 22,
      std::string(set.frictional ? "Frictional" : "Frictionless") + " contacts as the inertia’s conditioning grows",
      {.size = 17, .color = kInk, .bold = true});
  canvas.text(kMargin, 44, family.family + " · thin and dashed: not reliable there, or too few problems to say",
              {.color = kSoft});

  const LogAxis x(family.conditions, top.left, top.right);
  Panel error_panel{"↑ worse: " + measure_words(family.measure) + ", 99th percentile", power_of_ten, std::nullopt};
  if (reaches_floor(errors)) error_panel.heading += "; 0 is drawn at 10⁻¹⁷";
  if (family.measure == ErrorMeasure::kResidual) error_panel.bound = verdict_bound(set);
  draw_panel(canvas, top, errors, x, error_panel);
  const Panel cost_panel{relative ? "↑ slower: time over that of " + summary.reference + ", on the problems both solved"
                                  : "↑ slower: median time per problem (CPU)",
                         relative ? ratio_of_decade : time_of_decade, std::nullopt};
  draw_panel(canvas, bottom, costs, x, cost_panel);
  for (const Box& area : {top, bottom}) {
    for (const double condition : family.conditions) {
      canvas.text(x.pixel(condition), area.bottom + 14, condition_text(condition),
                  {.size = 11.5, .color = kInk, .align = Align::kCenter});
    }
    canvas.text((area.left + area.right) / 2, area.bottom + 32, "condition number of the inertia",
                {.color = kSoft, .align = Align::kCenter});
  }
  canvas.plot_area(bottom);
  canvas.command("unset border\nunset tics\nset xrange [0:1]\nset yrange [0:1]");
  return Figure{canvas.draw(escape(family.family + ": error and time over the condition number"), "plot NaN notitle"),
                alternative_text(summary, family)};
}

}  // namespace lcpbench::report
