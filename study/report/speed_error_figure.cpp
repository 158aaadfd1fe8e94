#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "study/report/axes.h"
#include "study/report/failure_strip.h"
#include "study/report/figures.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

constexpr double kErrorCeiling = 100;  // larger errors are drawn here, their value in the label
constexpr double kPlotHeight = 360;
constexpr double kLegendHeight = 26;

/// How a point stands to the others.
struct Rank {
  const char* color;
  const char* meaning;
};
constexpr Rank kFrontier{"#00703c", "frontier: reliable, none both faster and more accurate"};
constexpr Rank kReliable{"#1f5a99", "reliable"};
constexpr Rank kUnproven{"#8a8a8a", "not reliable, or too few to say"};
constexpr Rank kMisleading{kWrong, "the same, and wrong on some that it said were solved"};

const Rank& rank_of(const SpeedErrorPoint& point) {
  if (point.frontier) return kFrontier;
  if (point.reliable()) return kReliable;
  return point.cell->false_claims() > 0 ? kMisleading : kUnproven;
}

/// A point with errors that fit on the axis.
struct DrawnPoint {
  const SpeedErrorPoint* point = nullptr;
  std::string label;
  double cost = 0;
  double error = 0;
  double median_error = 0;
};

std::vector<DrawnPoint> points_of(const Summary& summary, const SpeedError& speed_error) {
  std::vector<DrawnPoint> drawn;
  for (const SpeedErrorPoint& point : speed_error.points) {
    if (!point.placed()) continue;
    DrawnPoint entry{&point, rung_label(summary, *point.cell), point.cost.value, 0, 0};
    entry.error = std::clamp(point.p99, kErrorFloor, kErrorCeiling);
    entry.median_error = std::clamp(point.median, kErrorFloor, kErrorCeiling);
    if (point.p99 > kErrorCeiling) entry.label += ": " + scientific(point.p99);
    if (point.reliable() && point.cell->false_claims() > 0)
      entry.label += fmt::format(": {} false", point.cell->false_claims());
    drawn.push_back(std::move(entry));
  }
  return drawn;
}

/// Is there an error too small to be drawn where it is, 0 above all?
bool reaches_floor(const std::vector<DrawnPoint>& points) {
  return std::any_of(points.begin(), points.end(),
                     [](const DrawnPoint& point) { return point.point->median < kErrorFloor; });
}

std::string undrawn_note(const Summary& summary, const SpeedError& speed_error) {
  std::string names;
  for (const SpeedErrorPoint& point : speed_error.points) {
    if (!point.placed()) names += (names.empty() ? "" : ", ") + rung_label(summary, point.cell->solver);
  }
  return names.empty() ? "" : shorten("No point (no answer said solved, or no error or time known): " + names, 125);
}

/// The steps that no reliable solver goes below. @returns where they are.
std::vector<Box> draw_frontier(Canvas& canvas, std::vector<DrawnPoint> points, const LogAxis& x, const LogAxis& y) {
  std::vector<Box> steps;
  std::erase_if(points, [](const DrawnPoint& point) { return !point.point->frontier; });
  std::sort(points.begin(), points.end(), [](const DrawnPoint& a, const DrawnPoint& b) { return a.cost < b.cost; });
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double left = x.pixel(points[i - 1].cost);
    const double right = x.pixel(points[i].cost);
    const double above = y.pixel(points[i - 1].error);
    const double below = y.pixel(points[i].error);
    canvas.line(left, above, right, above, kFrontier.color, 1.2, false, Layer::kBack);
    canvas.line(right, above, right, below, kFrontier.color, 1.2, false, Layer::kBack);
    steps.push_back({left, above - 1, right, above + 1});
    steps.push_back({right - 1, above, right + 1, below});
  }
  return steps;
}

/// The points with their labels, clear of each other and of the obstacles. @returns the plot command with its data.
std::string draw_points(Canvas& canvas, const std::vector<DrawnPoint>& points, const Box& area, const LogAxis& x,
                        const LogAxis& y, std::vector<Box> obstacles) {
  std::vector<LabelledPoint> wishes;
  std::string plot;
  std::string data;
  for (const DrawnPoint& point : points) {
    const Rank& rank = rank_of(*point.point);
    const double px = x.pixel(point.cost);
    const double py = y.pixel(point.error);
    const double median_y = y.pixel(point.median_error);
    wishes.push_back({px, py, static_cast<double>(character_count(point.label)) * kLabelSize * kMonospaceWidth + 4});
    obstacles.push_back({px - 2, std::min(py, median_y), px + 2, std::max(py, median_y)});
    canvas.line(px, py, px, median_y, "#b9c4d0", 2, false, Layer::kBack);
    canvas.line(px - 4, median_y, px + 4, median_y, "#b9c4d0", 2, false, Layer::kBack);
    plot += fmt::format("{}'-' using 1:2 with points pointtype 7 pointsize {} linecolor rgb '{}'",
                        plot.empty() ? "plot " : ", ", point.point->frontier ? "1.1" : "0.8", rank.color);
    data += fmt::format("{:.9g} {:.9g}\ne\n", std::log10(point.cost), std::log10(point.error));
  }
  const std::vector<PlacedLabel> placed = place_labels(wishes, obstacles, area, kLabelHeight);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Box& box = placed[i].box;
    if (placed[i].leader) {
      canvas.line(wishes[i].x, wishes[i].y, std::clamp(wishes[i].x, box.left, box.right),
                  std::clamp(wishes[i].y, box.top + 2, box.bottom - 2), "#888888", 0.8);
    }
    canvas.text(box.left + 2, (box.top + box.bottom) / 2, points[i].label,
                {.size = kLabelSize, .color = rank_of(*points[i].point).color, .monospace = true});
  }
  return plot + "\n" + data;
}

void draw_legend(Canvas& canvas, const std::vector<DrawnPoint>& points, double y) {
  double x = kMargin;
  for (const Rank* rank : {&kFrontier, &kReliable, &kUnproven, &kMisleading}) {
    const bool seen = std::any_of(points.begin(), points.end(),
                                  [rank](const DrawnPoint& point) { return &rank_of(*point.point) == rank; });
    if (!seen) continue;
    canvas.rectangle({x, y - 4, x + 8, y + 4}, rank->color);
    canvas.text(x + 13, y, rank->meaning, {.size = 11, .color = rank->color});
    x += 13 + static_cast<double>(character_count(rank->meaning)) * 11 * 0.5 + 18;
  }
}

/// Where a text at the line y fits beside the points: at the right or left end of the area, above the line or below.
Box free_place(const Box& area, double y, double width, const std::vector<Box>& taken) {
  constexpr double kHeight = 18;
  const Box places[] = {{area.right - width, y - kHeight, area.right, y},
                        {area.left, y - kHeight, area.left + width, y},
                        {area.right - width, y, area.right, y + kHeight},
                        {area.left, y, area.left + width, y + kHeight}};
  for (const Box& place : places) {
    if (std::none_of(taken.begin(), taken.end(), [&](const Box& box) { return box.overlap(place) > 0; })) return place;
  }
  return places[0];
}

/// The points and the bars to their medians.
std::vector<Box> boxes_of(const std::vector<DrawnPoint>& points, const LogAxis& x, const LogAxis& y) {
  constexpr double kRadius = 6;
  std::vector<Box> boxes;
  for (const DrawnPoint& point : points) {
    const double px = x.pixel(point.cost);
    const double py = y.pixel(point.error);
    const double median_y = y.pixel(point.median_error);
    boxes.push_back({px - kRadius, std::min(py, median_y) - kRadius, px + kRadius, std::max(py, median_y) + kRadius});
  }
  return boxes;
}

/// The bound above which no answer counts as solved, where the error is the one that the verdict is taken on.
std::vector<Box> draw_bound(Canvas& canvas, const SetSummary& set, const SpeedError& speed_error, const Box& area,
                            const LogAxis& y, const std::vector<Box>& taken) {
  if (speed_error.measure == ErrorMeasure::kForward) return {};
  const double bound = y.pixel(verdict_bound(set));
  canvas.line(area.left, bound, area.right, bound, kWrong, 1, true);
  const std::string text =
      set.bare ? "above 10⁻⁹ an answer does not count as solved" : "above 10⁻⁴ an answer does not count as solved";
  const double width = static_cast<double>(character_count(text)) * 11 * kProportionalWidth;
  const Box place = free_place(area, bound, width, taken);
  const bool at_right = place.right == area.right;
  canvas.text(at_right ? place.right : place.left + 4, (place.top + place.bottom) / 2, text,
              {.size = 11, .color = kWrong, .align = at_right ? Align::kRight : Align::kLeft});
  return {{area.left, bound - 2, area.right, bound + 2}, place};
}

std::string cost_words(const Summary& summary, const SpeedError& speed_error) {
  if (!speed_error.relative) return "← faster    median time per problem, set-up and solve (CPU)    slower →";
  return "← faster    time over that of " + summary.reference + ", on the problems both solved (CPU)    slower →";
}

std::string alternative_text(const Summary& summary, const SpeedError& speed_error) {
  std::string text =
      fmt::format("{}: {} against {}.", describe(summary.sets[speed_error.set]),
                  speed_error.relative ? "time over that of " + summary.reference : "median time per problem",
                  measure_words(speed_error.measure));
  for (const SpeedErrorPoint& point : speed_error.points) {
    const auto share = [&point](std::int64_t count) {
      return percent(static_cast<double>(count) / static_cast<double>(point.cell->trials));
    };
    text += fmt::format(" {}: {}, error median {}, 99th percentile {}, said solved and was wrong {}, gave up {}{}.",
                        summary.solvers[point.cell->solver].text(),
                        speed_error.relative ? factor(point.cost.value) : duration(point.cost.value),
                        scientific(point.median), scientific(point.p99), share(point.cell->false_claims()),
                        share(point.cell->gave_up()), point.frontier ? ", on the frontier" : "");
  }
  return text;
}

}  // namespace

std::optional<Figure> speed_error_figure(const Summary& summary, const SpeedError& speed_error) {
  const SetSummary& set = summary.sets[speed_error.set];
  const std::vector<DrawnPoint> points = points_of(summary, speed_error);
  if (points.empty()) return std::nullopt;
  const FailureStrip strip(summary, drawn_cells(summary, speed_error.set));
  const std::string note = undrawn_note(summary, speed_error);

  const Box area{84, 92, kWidth - 2 * kMargin, 92 + kPlotHeight};
  const double strip_top = area.bottom + 56 + kLegendHeight + (note.empty() ? 0 : 18);
  Canvas canvas(kWidth, strip_top + strip.height() + 8);
  draw_heading(canvas, set);

  std::vector<double> costs;
  std::vector<double> errors;
  if (speed_error.measure != ErrorMeasure::kForward) errors.push_back(verdict_bound(set) * 10);
  for (const DrawnPoint& point : points) {
    costs.push_back(point.cost);
    errors.push_back(point.error);
    errors.push_back(point.median_error);
  }
  const LogAxis x(costs, area.left, area.right);
  const LogAxis y(errors, area.bottom, area.top);
  draw_frame(canvas, area, fmt::format("[{}:{}]", x.low(), x.high()),
             x.tics(9, speed_error.relative ? ratio_of_decade : time_of_decade),
             fmt::format("[{}:{}]", y.low(), y.high()), y.tics(9, power_of_ten));
  canvas.text(kMargin, area.top - 20,
              "↑ worse: " + measure_words(speed_error.measure) +
                  ", of the answers said to be solved; dot 99th percentile, bar to the median" +
                  (reaches_floor(points) ? "; 0 is drawn at 10⁻¹⁷" : ""),
              {.size = 11.5, .color = kSoft});
  canvas.text((area.left + area.right) / 2, area.bottom + 38, cost_words(summary, speed_error),
              {.color = kSoft, .align = Align::kCenter});
  draw_legend(canvas, points, area.bottom + 62);
  if (!note.empty()) canvas.text(kMargin, area.bottom + 82, note, {.size = 11, .color = kSoft});
  strip.draw(canvas, strip_top);
  std::vector<Box> obstacles = draw_frontier(canvas, points, x, y);
  for (const Box& box : draw_bound(canvas, set, speed_error, area, y, boxes_of(points, x, y))) obstacles.push_back(box);
  const std::string plot = draw_points(canvas, points, area, x, y, obstacles);
  return Figure{canvas.draw(escape(describe(set) + ": speed against error"), plot),
                alternative_text(summary, speed_error)};
}

}  // namespace lcpbench::report
