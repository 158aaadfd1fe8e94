#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "study/report/axes.h"
#include "study/report/figures.h"
#include "study/report/speed_error.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

constexpr double kRowHeight = 19;
constexpr double kHeadingHeight = 30;
constexpr double kLineHeight = 16;
constexpr std::size_t kLineLimit = 128;

constexpr double kPlotHeight = 360;
constexpr double kBandHeight = 64;
constexpr double kLegendHeight = 26;
constexpr std::size_t kMostNames = 14;  // beside points; the others have numbers

/// How a point stands to the others.
struct Rank {
  const char* color;
  Shape shape;
  bool hollow;
  const char* meaning;
};
constexpr Rank kFrontier{kGood, Shape::kDisc, false, "frontier: reliable, none both faster and more accurate"};
constexpr Rank kReliable{kPlain, Shape::kDisc, false, "reliable"};
constexpr Rank kUnproven{kGrey, Shape::kSquare, false, "not reliable, or too few to say"};
constexpr Rank kMisleading{kWrong, Shape::kDiamond, false, "the same, and wrong on some that it said were solved"};
constexpr Rank kFailed{kWrong, Shape::kDisc, true, "failed: solved less than 90 %"};
constexpr Rank kFailedAndWrong{kWrong, Shape::kDiamond, true, "failed, and wrong on some that it said were solved"};

const Rank& rank_of(const SpeedErrorPoint& point) {
  const bool misled = point.cell->false_claims() > 0;
  if (point.failed()) return misled ? kFailedAndWrong : kFailed;
  if (point.frontier) return kFrontier;
  if (point.reliable()) return kReliable;
  return misled ? kMisleading : kUnproven;
}

/// A point with errors that fit on the axis.
struct DrawnPoint {
  const SpeedErrorPoint* point = nullptr;
  std::string name;
  std::string label;  ///< beside the point: its name, or its number in the list below
  double cost = 0;
  double error = 0;
  double median_error = 0;
};

/// In the order of their cost. Points on the frontier and points that said solved and were wrong are labelled with
/// their names, as far as there are at most kMostNames; the others with numbers.
std::vector<DrawnPoint> points_of(const Summary& summary, const SpeedError& speed_error) {
  std::vector<DrawnPoint> drawn;
  for (const SpeedErrorPoint& point : speed_error.points) {
    if (!point.placed()) continue;
    DrawnPoint entry{&point, rung_label(summary, *point.cell), "", point.cost.value, 0, 0};
    entry.error = std::clamp(point.p99, kErrorFloor, kErrorCeiling);
    entry.median_error = std::clamp(point.median, kErrorFloor, kErrorCeiling);
    if (point.p99 > kErrorCeiling && !point.failed()) entry.name += ": " + scientific(point.p99);
    if (point.reliable() && point.cell->false_claims() > 0)
      entry.name += fmt::format(": {} false", point.cell->false_claims());
    drawn.push_back(std::move(entry));
  }
  std::stable_sort(drawn.begin(), drawn.end(),
                   [](const DrawnPoint& a, const DrawnPoint& b) { return a.cost < b.cost; });
  std::size_t names = 0;
  for (const bool frontier : {true, false}) {
    for (DrawnPoint& entry : drawn) {
      const bool wanted = frontier ? entry.point->frontier : entry.point->cell->false_claims() > 0;
      if (wanted && entry.label.empty() && ++names <= kMostNames) entry.label = entry.name;
    }
  }
  return drawn;
}

/// Numbers for the points that have no names beside them, in the order of the list.
void number_points(std::vector<DrawnPoint>& points) {
  int number = 0;
  for (DrawnPoint& entry : points) {
    if (entry.label != entry.name) entry.label = std::to_string(++number);
  }
}

/// Is there an error too small to be drawn where it is, 0 above all?
bool reaches_floor(const std::vector<DrawnPoint>& points) {
  return std::any_of(points.begin(), points.end(), [](const DrawnPoint& point) {
    return !point.point->failed() && point.point->median < kErrorFloor;
  });
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

/// Where points stand: those that failed in the band above the errors.
struct Place {
  const Box& area;
  const LogAxis& x;
  const LogAxis& y;

  double band() const { return area.top - kBandHeight / 2; }
  double of(const DrawnPoint& point) const { return point.point->failed() ? band() : y.pixel(point.error); }
  double of_median(const DrawnPoint& point) const {
    return point.point->failed() ? band() : y.pixel(point.median_error);
  }
};

/// Labels for all points. Where names crowd, those of the least consequence give way to numbers, one after the other.
std::vector<PlacedLabel> place_names(std::vector<DrawnPoint>& points, const Place& place,
                                     const std::vector<Box>& obstacles, std::vector<LabelledPoint>& wishes) {
  const Box room{place.area.left, place.area.top - kBandHeight, place.area.right, place.area.bottom};
  while (true) {
    number_points(points);
    wishes.clear();
    for (const DrawnPoint& point : points) {
      const auto characters = static_cast<double>(character_count(point.label));
      wishes.push_back({place.x.pixel(point.cost), place.of(point), characters * kLabelSize * kMonospaceWidth + 4});
    }
    std::vector<PlacedLabel> placed = place_labels(wishes, obstacles, room, kLabelHeight);
    DrawnPoint* least = nullptr;
    for (const std::size_t i : crowded_labels(wishes, placed)) {
      if (points[i].label != points[i].name) continue;
      if (least == nullptr || !points[i].point->frontier) least = &points[i];
    }
    if (least == nullptr) return placed;
    least->label.clear();
  }
}

/// The points with their labels, clear of each other and of the obstacles.
void draw_points(Canvas& canvas, std::vector<DrawnPoint>& points, const Place& place, std::vector<Box> obstacles) {
  for (const DrawnPoint& point : points) {
    const Rank& rank = rank_of(*point.point);
    const double px = place.x.pixel(point.cost);
    const double py = place.of(point);
    const double median_y = place.of_median(point);
    canvas.marker(px, py, point.point->frontier ? 5.5 : 4.2, rank.shape, rank.color, rank.hollow);
    if (point.point->failed()) continue;
    obstacles.push_back({px - 2, std::min(py, median_y), px + 2, std::max(py, median_y)});
    canvas.line(px, py, px, median_y, kFaint, 2, false, Layer::kBack);
    canvas.line(px - 4, median_y, px + 4, median_y, kFaint, 2, false, Layer::kBack);
  }
  std::vector<LabelledPoint> wishes;
  const std::vector<PlacedLabel> placed = place_names(points, place, obstacles, wishes);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Box& box = placed[i].box;
    if (placed[i].leader) {
      canvas.line(wishes[i].x, wishes[i].y, std::clamp(wishes[i].x, box.left, box.right),
                  std::clamp(wishes[i].y, box.top + 2, box.bottom - 2), kAxis, 0.8);
    }
    canvas.text(box.left + 2, (box.top + box.bottom) / 2, points[i].label,
                {.size = kLabelSize, .color = rank_of(*points[i].point).color, .monospace = true});
  }
}

/// The band above the errors, where some solver failed.
void draw_band(Canvas& canvas, const Box& area) {
  const double top = area.top - kBandHeight;
  canvas.line(area.left, top, area.right, top, kGrid, 1, false, Layer::kBack);
  canvas.line(area.left, area.top, area.right, area.top, kWrong, 1, false, Layer::kBack);
  canvas.text(area.left - 6, area.top - kBandHeight / 2, "failed", {.color = kWrong, .align = Align::kRight});
}

/// The names of the points that have numbers, in columns. @returns the height that they took.
double draw_numbered_names(Canvas& canvas, const std::vector<DrawnPoint>& points, double top) {
  std::vector<std::pair<std::string, const char*>> entries;
  std::size_t longest = 0;
  for (const DrawnPoint& point : points) {
    if (point.label == point.name) continue;
    entries.emplace_back(fmt::format("{:>2}  {}", point.label, point.name), rank_of(*point.point).color);
    longest = std::max(longest, character_count(entries.back().first));
  }
  if (entries.empty()) return 0;
  const double wanted = static_cast<double>(longest) * kLabelSize * kMonospaceWidth + 14;
  const auto columns = static_cast<std::size_t>(std::max(1.0, std::floor((kWidth - 2 * kMargin) / wanted)));
  const double width = (kWidth - 2 * kMargin) / static_cast<double>(columns);
  const std::size_t rows = (entries.size() + columns - 1) / columns;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    canvas.text(kMargin + static_cast<double>(i / rows) * width,
                top + kLabelHeight * (static_cast<double>(i % rows) + 0.5), entries[i].first,
                {.size = kLabelSize, .color = entries[i].second, .monospace = true});
  }
  return kLabelHeight * static_cast<double>(rows) + 8;
}

/// @returns the height that it took.
double draw_legend(Canvas& canvas, const std::vector<DrawnPoint>& points, double y) {
  double x = kMargin;
  const double top = y;
  for (const Rank* rank : {&kFrontier, &kReliable, &kUnproven, &kMisleading, &kFailed, &kFailedAndWrong}) {
    const bool seen = std::any_of(points.begin(), points.end(),
                                  [rank](const DrawnPoint& point) { return &rank_of(*point.point) == rank; });
    if (!seen) continue;
    const double width = 13 + static_cast<double>(character_count(rank->meaning)) * 11 * 0.54 + 20;
    if (x > kMargin && x + width > kWidth) {
      x = kMargin;
      y += 18;
    }
    canvas.marker(x + 4, y, 4.2, rank->shape, rank->color, rank->hollow);
    canvas.text(x + 13, y, rank->meaning, {.size = 11, .color = rank->color});
    x += width;
  }
  return y - top + kLegendHeight;
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
std::vector<Box> boxes_of(const std::vector<DrawnPoint>& points, const Place& place) {
  constexpr double kRadius = 6;
  std::vector<Box> boxes;
  for (const DrawnPoint& point : points) {
    const double px = place.x.pixel(point.cost);
    const double py = place.of(point);
    const double median_y = place.of_median(point);
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
  if (!speed_error.relative) return "← faster · median time per problem, set-up and solve (CPU) · slower →";
  return "← faster · time over that of " + summary.reference + ", on the problems both solved (CPU) · slower →";
}

/// What the picture is there to show; the numbers of all points stand in the table beside it.
std::string alternative_text(const Summary& summary, const SpeedError& speed_error) {
  std::string frontier;
  std::string failed;
  std::string wrong;
  const auto add = [](std::string& list, const std::string& entry) { list += (list.empty() ? "" : "; ") + entry; };
  for (const SpeedErrorPoint& point : speed_error.points) {
    const std::string& name = summary.solvers[point.cell->solver].text();
    if (point.frontier) {
      add(frontier, fmt::format("{}, {}, error {}", name,
                                cost_text(speed_error, point),
                                scientific(point.p99)));
    }
    if (point.placed() && point.failed()) add(failed, name);
    if (point.cell->false_claims() > 0) add(wrong, name);
  }
  const auto sentence = [](const char* what, const std::string& list) {
    return list.empty() ? std::string() : std::string(" ") + what + ": " + list + ".";
  };
  return fmt::format("{}: {} against {}.", describe(summary.sets[speed_error.set]),
                     speed_error.relative ? "time over that of " + summary.reference : "median time per problem",
                     measure_words(speed_error.measure)) +
         sentence("On the frontier", frontier) + sentence("Failed", failed) +
         sentence("Said solved and was wrong", wrong);
}

LogAxis error_axis(const SetSummary& set, const SpeedError& speed_error, const std::vector<DrawnPoint>& points,
                   const Box& area) {
  std::vector<double> errors;
  if (speed_error.measure != ErrorMeasure::kForward) errors.push_back(verdict_bound(set) * 10);
  for (const DrawnPoint& point : points) {
    if (point.point->failed()) continue;
    errors.push_back(point.error);
    errors.push_back(point.median_error);
  }
  if (errors.empty()) errors.push_back(verdict_bound(set));
  return LogAxis(errors, area.bottom, area.top);
}

// --- below the points: who failed ---

void draw_bar(Canvas& canvas, double left, double y, double full_width, double share, const char* color) {
  const double width = std::max(share > 0 ? 1.5 : 0.0, share * full_width);
  canvas.line(left, y - 7, left, y + 7, kAxis, 1);
  if (width > 0) canvas.rectangle({left, y - 6, left + width, y + 6}, color);
  canvas.text(left + width + 5, y, percent(share),
              {.size = kLabelSize, .color = share > 0 ? kInk : kSoft, .bold = share > 0});
}

/// Breaks a list of words at commas into lines of at most `limit` characters each.
std::vector<std::string> lines_of(const std::string& text, std::size_t limit) {
  std::vector<std::string> lines{""};
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t comma = text.find(", ", begin);
    const std::size_t end = comma == std::string::npos ? text.size() : comma + 2;
    const std::string word = text.substr(begin, end - begin);
    const bool full = character_count(lines.back()) + character_count(word) > limit;
    if (full && !lines.back().empty()) lines.emplace_back();
    lines.back() += word;
    begin = end;
  }
  return lines;
}

/// The shares of its problems that a solver answered wrongly while saying solved, and gave up on.
struct Failures {
  std::string label;
  double wrong = 0;
  double gave_up = 0;
};

/// Of the solvers that failed on some problem, the least failures first, wrong answers before all; the others are
/// named in `faultless`.
std::vector<Failures> failures_of(const Summary& summary, const std::vector<const Cell*>& cells,
                                  std::string& faultless) {
  std::vector<Failures> failures;
  for (const Cell* cell : cells) {
    Failures row{rung_label(summary, *cell), Share{cell->false_claims(), cell->trials}.value(),
                 Share{cell->gave_up(), cell->trials}.value()};
    if (row.wrong + row.gave_up > 0) {
      failures.push_back(std::move(row));
    } else {
      faultless += (faultless.empty() ? "" : ", ") + row.label;
    }
  }
  std::stable_sort(failures.begin(), failures.end(), [](const Failures& a, const Failures& b) {
    return std::pair(a.wrong, a.gave_up) < std::pair(b.wrong, b.gave_up);
  });
  return failures;
}

/// A sentence on who never failed, then a row of bars for each of the others. @returns the height that it took.
double draw_failures(Canvas& canvas, const Summary& summary, const std::vector<const Cell*>& cells, double top) {
  std::string faultless;
  const std::vector<Failures> rows = failures_of(summary, cells, faultless);
  double y = top + kLineHeight / 2;
  if (!faultless.empty()) {
    for (const std::string& line : lines_of("No failure seen: " + faultless, kLineLimit)) {
      canvas.text(kMargin, y, line, {.size = 11.5, .color = kSoft});
      y += kLineHeight;
    }
  }
  if (rows.empty()) return y - kLineHeight / 2 - top;
  struct Column {
    const char* heading;
    const char* color;
    double Failures::*share;
  };
  constexpr std::array<Column, 2> columns{
      {{"said solved, was wrong", kWrong, &Failures::wrong}, {"gave up", kGrey, &Failures::gave_up}}};

  std::size_t longest = 0;
  for (const Failures& row : rows) longest = std::max(longest, character_count(row.label));
  const double names_end = kMargin + static_cast<double>(longest) * kLabelSize * kMonospaceWidth + 4;
  const double column_width = (kWidth - names_end - kMargin) / static_cast<double>(columns.size());
  const double first_row = y + kHeadingHeight - kLineHeight / 2;
  const auto row_y = [first_row](std::size_t i) { return first_row + kRowHeight * static_cast<double>(i); };
  for (std::size_t column = 0; column < columns.size(); ++column) {
    const double left = names_end + 10 + static_cast<double>(column) * column_width;
    canvas.text(left, y + 4, columns[column].heading, {.color = columns[column].color, .bold = true});
    for (std::size_t i = 0; i < rows.size(); ++i) {
      draw_bar(canvas, left, row_y(i), column_width - 75, rows[i].*columns[column].share, columns[column].color);
    }
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    canvas.text(names_end, row_y(i), rows[i].label, {.align = Align::kRight, .monospace = true});
  }
  return y - kLineHeight / 2 + kHeadingHeight + kRowHeight * static_cast<double>(rows.size()) - top;
}

}  // namespace

std::optional<Figure> speed_error_figure(const Summary& summary, const SpeedError& speed_error) {
  const SetSummary& set = summary.sets[speed_error.set];
  std::vector<DrawnPoint> points = points_of(summary, speed_error);
  if (points.empty()) return std::nullopt;
  const std::string note = undrawn_note(summary, speed_error);
  const bool any_failed =
      std::any_of(points.begin(), points.end(), [](const DrawnPoint& point) { return point.point->failed(); });

  const double top = 92 + (any_failed ? kBandHeight : 0);
  const Box area{84, top, kWidth - 2 * kMargin, top + kPlotHeight};
  std::vector<double> costs;
  for (const DrawnPoint& point : points) costs.push_back(point.cost);
  const LogAxis x(costs, area.left, area.right);
  const LogAxis y = error_axis(set, speed_error, points, area);
  const Place place{area, x, y};

  Canvas canvas(kWidth);
  draw_heading(canvas, set);
  draw_frame(canvas, area, x.tics(9, speed_error.relative ? ratio_of_decade : time_of_decade), y.tics(9, power_of_ten));
  if (any_failed) draw_band(canvas, area);
  canvas.text(kMargin, 72,
              "↑ worse: " + measure_words(speed_error.measure) +
                  ", of the answers said to be solved; dot 99th percentile, bar to the median" +
                  (reaches_floor(points) ? "; 0 is drawn at 10⁻¹⁷" : ""),
              {.size = 11.5, .color = kSoft});
  canvas.text((area.left + area.right) / 2, area.bottom + 38, cost_words(summary, speed_error),
              {.color = kSoft, .align = Align::kCenter});
  std::vector<Box> obstacles = draw_frontier(canvas, points, x, y);
  for (const Box& box : draw_bound(canvas, set, speed_error, area, y, boxes_of(points, place)))
    obstacles.push_back(box);
  draw_points(canvas, points, place, obstacles);

  double below = area.bottom + 62;
  below += draw_legend(canvas, points, below) - 8;
  below += draw_numbered_names(canvas, points, below);
  if (!note.empty()) {
    canvas.text(kMargin, below + 9, note, {.size = 11, .color = kSoft});
    below += 18;
  }
  below += draw_failures(canvas, summary, drawn_cells(summary, speed_error.set), below);
  canvas.set_height(below + 8);
  const std::string alternative = alternative_text(summary, speed_error);
  return Figure{canvas.draw(describe(set) + ": speed against error", alternative), alternative, ""};
}

}  // namespace lcpbench::report
