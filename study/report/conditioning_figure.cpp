#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "study/report/axes.h"
#include "study/report/figures.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

constexpr double kPanelHeight = 250;
constexpr double kGap = 92;
constexpr double kBandHeight = 34;
constexpr std::size_t kColorsInTurn = 10;
constexpr std::array kMarkers{Shape::kSquare,  Shape::kDisc,  Shape::kTriangle,
                              Shape::kDiamond, Shape::kCross, Shape::kPlus};

/// One solver along the dial; value is what the panel shows.
struct Line {
  struct Point {
    double condition = 0;
    double value = 0;
    bool reliable = false;
    bool failed = false;  ///< has no error of its own
  };
  std::string label;
  std::size_t number = 0;     ///< gives colour and shape
  std::vector<Point> points;  ///< ascending by condition
  bool reaches_the_end = false;
};

std::vector<Line> lines_of(const Summary& summary, const Conditioning& family,
                           double (*value)(const SpeedErrorPoint&)) {
  std::vector<Line> lines;
  for (std::size_t i = 0; i < family.solvers.size(); ++i) {
    Line line{shorten(rung_label(summary, family.solvers[i]), 34), i, {}, false};
    for (std::size_t step = 0; step < family.steps.size(); ++step) {
      for (const SpeedErrorPoint& point : family.steps[step].points) {
        if (point.cell->solver != family.solvers[i] || !point.placed()) continue;
        line.points.push_back({family.conditions[step], value(point), point.reliable(), point.failed()});
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
  bool failures_apart = false;  ///< those that failed stand in a band above the values
};

bool apart(const Panel& panel, const Line::Point& point) { return panel.failures_apart && point.failed; }

/// One solver's points, and the lines between them. A line ends where the solver failed.
void draw_line(Canvas& canvas, const Box& area, const Line& line, const LogAxis& x, const LogAxis& y,
               const Panel& panel) {
  const char* color = curve_color(line.number);
  const Shape shape = kMarkers[line.number / kColorsInTurn % kMarkers.size()];
  const auto height = [&](const Line::Point& point) {
    return apart(panel, point) ? area.top - kBandHeight / 2 : y.pixel(point.value);
  };
  for (std::size_t k = 0; k < line.points.size(); ++k) {
    const Line::Point& point = line.points[k];
    // In the band all would stand on one another.
    const double aside = apart(panel, point) ? 6.0 * (static_cast<double>(line.number % 9) - 4) : 0;
    const double px = x.pixel(point.condition) + aside;
    if (k > 0 && !apart(panel, point) && !apart(panel, line.points[k - 1])) {
      const bool reliable = point.reliable && line.points[k - 1].reliable;
      canvas.line(x.pixel(line.points[k - 1].condition), height(line.points[k - 1]), px, height(point), color,
                  reliable ? 1.6 : 0.9, !reliable);
    }
    canvas.marker(px, height(point), point.reliable ? 3.6 : 2.8, shape, color, point.failed);
  }
}

void draw_panel(Canvas& canvas, const Box& area, const std::vector<Line>& lines, const LogAxis& x,
                const std::vector<double>& conditions, const Panel& panel) {
  std::vector<double> values;
  if (panel.bound) values.push_back(*panel.bound);
  for (const Line& line : lines) {
    for (const Line::Point& point : line.points) {
      if (!apart(panel, point)) values.push_back(point.value);
    }
  }
  if (values.empty()) values.push_back(1);
  const LogAxis y(values, area.bottom, area.top);
  canvas.text(kMargin, area.top - 18 - (panel.failures_apart ? kBandHeight : 0), panel.heading, {.color = kSoft});
  std::vector<Tic> x_tics;
  for (const double condition : conditions) x_tics.push_back({x.pixel(condition), condition_text(condition)});
  draw_frame(canvas, area, x_tics, y.tics(8, panel.tic));
  if (panel.failures_apart) {
    canvas.line(area.left, area.top, area.right, area.top, kWrong, 1, false, Layer::kBack);
    canvas.text(area.left - 6, area.top - kBandHeight / 2, "failed", {.color = kWrong, .align = Align::kRight});
  }
  if (panel.bound) {
    const double at = y.pixel(*panel.bound);
    canvas.line(area.left, at, area.right, at, kWrong, 1, true);
    canvas.text(area.left + 4, at - 9, "not solved above this", {.size = 11, .color = kWrong});
  }
  std::vector<double> ends;
  for (const Line& line : lines) {
    const Line::Point& last = line.points.back();
    ends.push_back(apart(panel, last) ? area.top - kBandHeight / 2 : y.pixel(last.value));
  }
  const double top = area.top - (panel.failures_apart ? kBandHeight / 2 : 0);
  const std::vector<double> labels = stack_labels(ends, top, area.bottom + 12, kLabelHeight - 1);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const char* color = curve_color(lines[i].number);
    draw_line(canvas, area, lines[i], x, y, panel);
    const double end = x.pixel(lines[i].points.back().condition);
    const bool to_the_last = lines[i].reaches_the_end;
    canvas.line(end + 5, ends[i], area.right + 14, labels[i], to_the_last ? color : kAxis, to_the_last ? 0.7 : 0.5,
                false, Layer::kBack);
    canvas.marker(area.right + 20, labels[i], 3.6, kMarkers[lines[i].number / kColorsInTurn % kMarkers.size()], color);
    canvas.text(area.right + 28, labels[i], lines[i].label, {.size = kLabelSize, .color = color, .monospace = true});
  }
}

std::string alternative_text(const Summary& summary, const Conditioning& family) {
  std::string text = family.family + ": " + measure_words(family.measure) + ", 99th percentile, by condition number.";
  for (const Line& line : lines_of(summary, family, drawn_error)) {
    text += " " + line.label + ":";
    for (const Line::Point& point : line.points) {
      text +=
          fmt::format(" {} at {},", point.failed ? "failed" : scientific(point.value), condition_text(point.condition));
    }
    text.back() = '.';
  }
  return text;
}

bool reaches_floor(const std::vector<Line>& errors) {
  return std::any_of(errors.begin(), errors.end(), [](const Line& line) {
    return std::any_of(line.points.begin(), line.points.end(),
                       [](const Line::Point& point) { return !point.failed && point.value <= kErrorFloor; });
  });
}

bool any_failed(const std::vector<Line>& lines) {
  return std::any_of(lines.begin(), lines.end(), [](const Line& line) {
    return std::any_of(line.points.begin(), line.points.end(), [](const Line::Point& point) { return point.failed; });
  });
}

double label_room(const std::vector<Line>& lines) {
  std::size_t longest = 0;
  for (const Line& line : lines) longest = std::max(longest, character_count(line.label));
  return static_cast<double>(longest) * kLabelSize * kMonospaceWidth + 32;
}

}  // namespace

std::optional<Figure> conditioning_figure(const Summary& summary, const Conditioning& family) {
  if (family.solvers.empty()) return std::nullopt;
  const std::vector<Line> errors = lines_of(summary, family, drawn_error);
  const std::vector<Line> costs = lines_of(summary, family, cost);
  const bool relative = family.steps.front().relative;
  const double height = std::max(kPanelHeight, (kLabelHeight - 1) * static_cast<double>(errors.size() + 1));
  const bool failures = any_failed(errors);
  const double begin = 92 + (failures ? kBandHeight : 0);
  const Box top{76, begin, kWidth - kMargin - label_room(errors), begin + height};
  const Box bottom{top.left, top.bottom + kGap, top.right, top.bottom + kGap + height};
  Canvas canvas(kWidth, bottom.bottom + 60);
  const SetSummary& set = summary.sets[family.steps.front().set];
  canvas.text(
      kMargin, 22,
      std::string(set.frictional ? "Frictional" : "Frictionless") + " contacts as the inertia’s conditioning grows",
      {.size = 17, .bold = true});
  canvas.text(kMargin, 44,
              family.family + " · thin and dashed: not reliable there, or too few problems to say" +
                  (failures ? " · hollow: failed, solved less than 90 %" : ""),
              {.color = kSoft});

  const LogAxis x(family.conditions, top.left, top.right);
  Panel error_panel{"↑ worse: " + measure_words(family.measure) + ", 99th percentile", power_of_ten, std::nullopt,
                    failures};
  if (reaches_floor(errors)) error_panel.heading += "; 0 is drawn at 10⁻¹⁷";
  if (family.measure == ErrorMeasure::kResidual) error_panel.bound = verdict_bound(set);
  draw_panel(canvas, top, errors, x, family.conditions, error_panel);
  const Panel cost_panel{relative ? "↑ slower: time over that of " + summary.reference + ", on the problems both solved"
                                  : "↑ slower: median time per problem (CPU)",
                         relative ? ratio_of_decade : time_of_decade, std::nullopt};
  draw_panel(canvas, bottom, costs, x, family.conditions, cost_panel);
  for (const Box& area : {top, bottom}) {
    canvas.text((area.left + area.right) / 2, area.bottom + 32, "condition number of the inertia",
                {.color = kSoft, .align = Align::kCenter});
  }
  const std::string alternative = alternative_text(summary, family);
  return Figure{canvas.draw(family.family + ": error and time over the condition number", alternative), alternative,
                ""};
}

}  // namespace lcpbench::report
