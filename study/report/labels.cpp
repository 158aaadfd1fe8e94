#include "study/report/labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

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

}  // namespace lcpbench::report
