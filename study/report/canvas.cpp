#include "study/report/canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include <fmt/format.h>

#include "study/report/text.h"

namespace lcpbench::report {

namespace {

constexpr double kPointRadius = 6;
constexpr double kLeaderGap = 16;
constexpr double kOverlapCost = 20;    // per square pixel: any overlap loses against any free place
constexpr double kCrossingCost = 400;  // a leader through another label or point
constexpr int kSweeps = 8;

/// Directions from point to label, in order of preference: the cost grows along the list.
struct Direction {
  double x;
  double y;
};
constexpr std::array<Direction, 12> kDirections{{{1, 0},
                                                 {-1, 0},
                                                 {0, -1},
                                                 {0, 1},
                                                 {0.9, -0.5},
                                                 {0.9, 0.5},
                                                 {-0.9, -0.5},
                                                 {-0.9, 0.5},
                                                 {0.5, -0.9},
                                                 {0.5, 0.9},
                                                 {-0.5, -0.9},
                                                 {-0.5, 0.9}}};
constexpr std::array<double, 8> kDistances{9, 14, 22, 32, 46, 64, 90, 130};

Box around(const LabelledPoint& point) {
  return {point.x - kPointRadius, point.y - kPointRadius, point.x + kPointRadius, point.y + kPointRadius};
}

Box candidate(const LabelledPoint& point, const Direction& direction, double distance, double height) {
  const auto side = [](double component) { return component > 0.4 ? 0.5 : component < -0.4 ? -0.5 : 0.0; };
  const double x = point.x + direction.x * distance + side(direction.x) * point.width;
  const double y = point.y + direction.y * distance + side(direction.y) * height;
  return {x - point.width / 2, y - height / 2, x + point.width / 2, y + height / 2};
}

/// Where a leader meets the box: its point nearest to the labelled point.
Direction nearest(const Box& box, const LabelledPoint& point) {
  return {std::clamp(point.x, box.left, box.right), std::clamp(point.y, box.top, box.bottom)};
}

double gap(const Box& box, const LabelledPoint& point) {
  const Direction end = nearest(box, point);
  return std::hypot(end.x - point.x, end.y - point.y);
}

/// Does the leader from the point to its box pass through `other`? Sampled every few pixels: the boxes are larger.
bool leader_crosses(const Box& box, const LabelledPoint& point, const Box& other) {
  const Direction end = nearest(box, point);
  const double length = std::hypot(end.x - point.x, end.y - point.y);
  const int steps = static_cast<int>(length / 3);
  for (int step = 1; step < steps; ++step) {
    const double t = static_cast<double>(step) / steps;
    const double x = point.x + t * (end.x - point.x);
    const double y = point.y + t * (end.y - point.y);
    if (x > other.left && x < other.right && y > other.top && y < other.bottom) return true;
  }
  return false;
}

/// Do the leaders of two points cross?
bool leaders_cross(const Box& box, const LabelledPoint& point, const Box& other_box, const LabelledPoint& other) {
  const Direction a{point.x, point.y};
  const Direction b = nearest(box, point);
  const Direction c{other.x, other.y};
  const Direction d = nearest(other_box, other);
  const auto side = [](const Direction& from, const Direction& to, const Direction& of) {
    return (to.x - from.x) * (of.y - from.y) - (to.y - from.y) * (of.x - from.x);
  };
  return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
}

class Placement {
 public:
  Placement(std::span<const LabelledPoint> points, std::span<const Box> obstacles, const Box& area, double height)
      : points_(points), obstacles_(obstacles), area_(area), height_(height), boxes_(points.size()) {
    for (std::size_t i = 0; i < points.size(); ++i) boxes_[i] = candidate(points[i], kDirections[0], 9, height);
  }

  std::vector<PlacedLabel> run() {
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      bool moved = false;
      for (std::size_t i = 0; i < points_.size(); ++i) moved = improve(i) || moved;
      if (!moved) break;
    }
    std::vector<PlacedLabel> placed;
    for (std::size_t i = 0; i < points_.size(); ++i)
      placed.push_back({boxes_[i], gap(boxes_[i], points_[i]) > kLeaderGap});
    return placed;
  }

 private:
  bool improve(std::size_t i) {
    const Box before = boxes_[i];
    double best = cost(i, before, 0);
    for (std::size_t near = 0; near < kDistances.size(); ++near) {
      for (std::size_t rank = 0; rank < kDirections.size(); ++rank) {
        const Box box = candidate(points_[i], kDirections[rank], kDistances[near], height_);
        const double price = cost(i, box, static_cast<double>(rank) / 4);
        if (price < best) {
          best = price;
          boxes_[i] = box;
        }
      }
    }
    return boxes_[i].left != before.left || boxes_[i].top != before.top;
  }

  double cost(std::size_t i, const Box& box, double preference) const {
    if (!area_.contains(box)) return std::numeric_limits<double>::max() / 2 + gap(box, points_[i]);
    double total = preference + gap(box, points_[i]);
    for (const Box& obstacle : obstacles_) total += kOverlapCost * box.overlap(obstacle);
    for (std::size_t other = 0; other < points_.size(); ++other) {
      total += kOverlapCost * box.overlap(around(points_[other]));
      if (other == i) continue;
      total += kOverlapCost * box.overlap(boxes_[other]);
      if (leader_crosses(box, points_[i], boxes_[other])) total += kCrossingCost;
      if (leader_crosses(box, points_[i], around(points_[other]))) total += kCrossingCost;
      if (leader_crosses(boxes_[other], points_[other], box)) total += kCrossingCost;
      if (leaders_cross(box, points_[i], boxes_[other], points_[other])) total += kCrossingCost;
    }
    return total;
  }

  std::span<const LabelledPoint> points_;
  std::span<const Box> obstacles_;
  Box area_;
  double height_;
  std::vector<Box> boxes_;
};

constexpr double kDefaultSize = 12;
constexpr double kBaseline = 0.36;  // of the size: half the height of capitals

/// A length to a hundredth of a pixel, without zeros at its end.
std::string px(double value) {
  std::string text = fmt::format("{:.2f}", value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string paint(const std::string& color) {
  return color.starts_with('#') ? "fill=\"" + color + "\"" : "class=\"" + color + "\"";
}

std::string stroke_attributes(const Stroke& stroke) {
  std::string attributes = fmt::format("class=\"l {}\"", stroke.color);
  if (stroke.width != 1) attributes += fmt::format(" stroke-width=\"{:g}\"", stroke.width);
  if (!stroke.dash.empty()) attributes += fmt::format(" stroke-dasharray=\"{}\"", stroke.dash);
  return attributes;
}

std::string outline(double x, double y, double r, Shape shape) {
  const auto at = [&](double dx, double dy) { return px(x + dx * r) + " " + px(y + dy * r); };
  switch (shape) {
    case Shape::kDisc: break;
    case Shape::kSquare: return "M" + at(-0.9, -0.9) + "L" + at(0.9, -0.9) + "L" + at(0.9, 0.9) + "L" + at(-0.9, 0.9);
    case Shape::kTriangle: return "M" + at(0, -1.1) + "L" + at(1.1, 0.9) + "L" + at(-1.1, 0.9);
    case Shape::kDiamond: return "M" + at(0, -1.25) + "L" + at(1.25, 0) + "L" + at(0, 1.25) + "L" + at(-1.25, 0);
    case Shape::kCross:
      return "M" + at(-1.1, -0.6) + "L" + at(-0.6, -1.1) + "L" + at(1.1, 0.6) + "L" + at(0.6, 1.1) + "zM" +
             at(1.1, -0.6) + "L" + at(0.6, -1.1) + "L" + at(-1.1, 0.6) + "L" + at(-0.6, 1.1);
    case Shape::kPlus:
      return "M" + at(-1.3, -0.4) + "L" + at(1.3, -0.4) + "L" + at(1.3, 0.4) + "L" + at(-1.3, 0.4) + "zM" +
             at(-0.4, -1.3) + "L" + at(0.4, -1.3) + "L" + at(0.4, 1.3) + "L" + at(-0.4, 1.3);
  }
  return "";
}

}  // namespace

bool Box::contains(const Box& other) const {
  return other.left >= left && other.right <= right && other.top >= top && other.bottom <= bottom;
}

double Box::overlap(const Box& other) const {
  const double width = std::min(right, other.right) - std::max(left, other.left);
  const double height = std::min(bottom, other.bottom) - std::max(top, other.top);
  return width > 0 && height > 0 ? width * height : 0;
}

std::vector<PlacedLabel> place_labels(std::span<const LabelledPoint> points, std::span<const Box> obstacles,
                                      const Box& area, double height) {
  return Placement(points, obstacles, area, height).run();
}

std::vector<std::size_t> crowded_labels(std::span<const LabelledPoint> points, std::span<const PlacedLabel> placed) {
  std::vector<std::size_t> crowded;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const Box& box = placed[i].box;
    bool any = false;
    for (std::size_t other = 0; other < placed.size(); ++other) {
      if (other == i) continue;
      const Box& second = placed[other].box;
      any = any || box.overlap(second) > 0 || (placed[i].leader && leader_crosses(box, points[i], second)) ||
            (placed[i].leader && placed[other].leader && leaders_cross(box, points[i], second, points[other]));
    }
    if (any) crowded.push_back(i);
  }
  return crowded;
}

std::vector<double> stack_labels(std::span<const double> wishes, double top, double bottom, double height) {
  std::vector<std::size_t> order(wishes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return wishes[a] < wishes[b]; });
  std::vector<double> placed(wishes.size());
  double y = top - height;
  for (const std::size_t i : order) {
    y = std::max(wishes[i], y + height);
    placed[i] = y;
  }
  double limit = bottom;
  for (auto i = order.rbegin(); i != order.rend(); ++i) {
    placed[*i] = std::min(placed[*i], limit);
    limit = placed[*i] - height;
  }
  return placed;
}

std::string shorten(const std::string& text, std::size_t limit) {
  return character_count(text) <= limit ? text : first_characters(text, limit - 1) + "…";
}

void Canvas::text(double x, double y, std::string_view text, const TextStyle& style) {
  const std::string color = style.color;
  const bool classed = !color.starts_with('#');
  std::string classes = style.monospace ? "m" : "";
  if (classed) classes += (classes.empty() ? "" : " ") + color;
  front_ += fmt::format("<text x=\"{}\" y=\"{}\"", px(x), px(y + kBaseline * style.size));
  if (!classes.empty()) front_ += " class=\"" + classes + "\"";
  if (!classed) front_ += " fill=\"" + color + "\"";
  if (style.align != Align::kLeft) {
    front_ += fmt::format(" text-anchor=\"{}\"", style.align == Align::kCenter ? "middle" : "end");
  }
  if (style.size != kDefaultSize) front_ += fmt::format(" font-size=\"{:g}\"", style.size);
  if (style.bold) front_ += " font-weight=\"bold\"";
  front_ += ">" + escape(text) + "</text>\n";
}

void Canvas::rectangle(const Box& box, const std::string& color) {
  front_ += fmt::format("<path {} d=\"M{} {}h{}v{}h{}z\"/>\n", paint(color), px(box.left), px(box.top),
                        px(box.right - box.left), px(box.bottom - box.top), px(box.left - box.right));
}

void Canvas::line(double x0, double y0, double x1, double y1, const char* color, double line_width, bool dashed,
                  Layer where) {
  layer(where) +=
      fmt::format("<path {} d=\"M{} {}L{} {}\"/>\n", stroke_attributes({color, line_width, dashed ? "6 4" : ""}),
                  px(x0), px(y0), px(x1), px(y1));
}

void Canvas::steps(const std::vector<std::pair<double, double>>& points, const Stroke& stroke) {
  std::string path;
  std::string drawn_x;  // as far as the path goes
  std::string x;
  std::string y;
  for (const auto& [at_x, at_y] : points) {
    const std::string next_x = fmt::format("{:.1f}", at_x);
    const std::string next_y = fmt::format("{:.1f}", at_y);
    if (path.empty()) {
      path = "M" + next_x + " " + next_y;
      drawn_x = next_x;
    } else if (next_y != y) {
      if (next_x != drawn_x) path += "H" + next_x;
      path += "V" + next_y;
      drawn_x = next_x;
    }
    x = next_x;
    y = next_y;
  }
  if (x != drawn_x) path += "H" + x;
  front_ += "<path " + stroke_attributes(stroke) + " d=\"" + path + "\"/>\n";
}

void Canvas::dots(const std::vector<std::pair<double, double>>& points, double radius, const char* color) {
  std::set<std::string> places;
  for (const auto& [x, y] : points) places.insert(fmt::format("M{:.1f} {:.1f}h0", x, y));
  if (places.empty()) return;
  std::string path;
  for (const std::string& place : places) path += place;
  front_ += fmt::format("<path class=\"l {}\" stroke-width=\"{}\" stroke-linecap=\"round\" d=\"{}\"/>\n", color,
                        px(2 * radius), path);
}

void Canvas::marker(double x, double y, double radius, Shape shape, const char* color, bool hollow) {
  const std::string classes = fmt::format("class=\"{}{}\"", hollow ? "h " : "", color);
  front_ += shape == Shape::kDisc
                ? fmt::format("<circle {} cx=\"{}\" cy=\"{}\" r=\"{}\"/>\n", classes, px(x), px(y), px(radius))
                : fmt::format("<path {} d=\"{}z\"/>\n", classes, outline(x, y, radius, shape));
}

void Canvas::bodies(const std::vector<std::string>& paths, const char* color) {
  front_ += fmt::format("<g class=\"{}\" fill-opacity=\"0.3\" stroke=\"currentColor\">\n", color);
  for (const std::string& path : paths) front_ += "<path d=\"" + path + "\"/>\n";
  front_ += "</g>\n";
}

std::string Canvas::draw(const std::string& title, const std::string& alternative) const {
  const std::string width = px(width_);
  const std::string height = px(height_);
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
             "role=\"img\" aria-label=\"{2}\" font-size=\"{3:g}\" fill=\"currentColor\">\n<title>{4}</title>\n"
             "<style>{5}</style>\n<path class=\"c-ground\" d=\"M0 0h{0}v{1}H0z\"/>\n",
             width, height, escape(alternative), kDefaultSize, escape(title), kFigureStyle) +
         back_ + front_ + "</svg>\n";
}

std::string inline_svg(const std::string& svg) {
  std::string text = svg;
  const auto cut = [&text](std::string_view first, std::string_view last) {
    const std::size_t begin = text.find(first);
    const std::size_t end = text.find(last, begin);
    if (end != std::string::npos) text.erase(begin, end + last.size() - begin);
  };
  cut("<style>", "</style>\n");
  cut(" xmlns=\"", "svg\"");
  return text;
}

}  // namespace lcpbench::report
