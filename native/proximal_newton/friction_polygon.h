#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/compliance.h"

namespace lcpbench {

/// The friction impulses that a pyramid of `edges` directions allows, for a normal impulse of 1 / mu: the convex hull
/// of the directions in the plane of the two tangents. Of two edges it is a line along the first tangent.
class FrictionPolygon {
 public:
  using Point = Eigen::Vector2d;

  explicit FrictionPolygon(Index edges) : edges_(edges), directions_(2, edges + 1) {
    for (Index k = 0; k <= edges; ++k) {
      const std::array<double, 2> d = edge_direction(k % edges, edges);
      directions_.col(k) << d[0], d[1];
    }
  }

  Index edges() const { return edges_; }
  /// Corner k of as many as there are edges, one more is the first again.
  Point direction(Index k) const { return directions_.col(k); }
  /// The side, between corners k and k + 1, that a ray through the point meets.
  Index side_of(const Point& other) const {
    Index side = 0;
    double farthest = -1;
    for (Index k = 0; k < edges_; ++k) {
      const double distance = (direction(k) + direction(k + 1)).dot(other);
      if (distance <= farthest) continue;
      farthest = distance;
      side = k;
    }
    return side;
  }

  /// The point of `size` times the polygon that is nearest to another, and how it moves with that one and with the
  /// size. A boundary between two cases counts to one of them.
  struct Nearest {
    Point point;
    Eigen::Matrix2d slope;  ///< d point / d other
    Point growth;           ///< d point / d size
  };

  Nearest nearest(const Point& other, double size) const {
    if (!(size > 0)) return {Point::Zero(), Eigen::Matrix2d::Zero(), Point::Zero()};
    if (edges_ == 2) return nearest_on_side(0, other, size);
    const Index side = side_of(other);
    const Point first = direction(side), along = (direction(side + 1) - first).normalized(),
                outward(along(1), -along(0));
    if (outward.dot(other) <= outward.dot(first) * size) return {other, Eigen::Matrix2d::Identity(), Point::Zero()};
    return nearest_on_side(side, other, size);
  }

  /// The same of the side between corners k and k + 1 alone, which of two edges is the polygon.
  Nearest nearest_on_side(Index k, const Point& other, double size) const {
    const Point first = direction(k), second = direction(k + 1);
    const Point along = (second - first).normalized(), outward(along(1), -along(0));
    const double least = along.dot(first) * size, most = along.dot(second) * size, at = along.dot(other);
    if (at > least && at < most) {
      const double distance = outward.dot(first);
      return {distance * size * outward + at * along, along * along.transpose(), distance * outward};
    }
    const Point corner = at <= least ? first : second;
    return {size * corner, Eigen::Matrix2d::Zero(), corner};
  }

  /// A point as impulses >= 0 along two neighbouring directions, with the least sum. Of two edges: one impulse of
  /// either sign along the first direction.
  struct Parts {
    std::array<Index, 2> directions{};
    std::array<double, 2> impulses{};
  };
  Parts split(const Point& point) const {
    if (edges_ == 2) return {{0, 0}, {point(0), 0}};
    const Index side = side_of(point);
    const Point first = direction(side), second = direction(side + 1);
    const double area = cross(first, second);
    return {{side, (side + 1) % edges_},
            {std::max(cross(point, second) / area, 0.0), std::max(cross(first, point) / area, 0.0)}};
  }

 private:
  static double cross(const Point& a, const Point& b) { return a(0) * b(1) - a(1) * b(0); }

  Index edges_;
  Eigen::Matrix2Xd directions_;  ///< the first once more at the end
};

}  // namespace lcpbench
