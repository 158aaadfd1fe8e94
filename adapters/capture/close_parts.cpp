#include "adapters/capture/close_parts.h"

#include <algorithm>
#include <cmath>

namespace lcpbench::capture {
namespace {

using Eigen::Vector3d;

std::vector<PlacedPart> placed_parts(const Scene& scene, const std::vector<Pose>& poses) {
  std::vector<PlacedPart> result;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    for (const Part& part : scene.bodies[i].parts) {
      const Pose& pose = poses[result.size()];
      result.push_back({i, part.kind, part.size, pose.position, pose.rotation.toRotationMatrix()});
    }
  }
  return result;
}

/// Of the ball around the part.
double radius(const PlacedPart& part) { return part.kind == Part::Kind::kSphere ? part.size.x() : part.size.norm(); }

Touch between_balls(const PlacedPart& a, const PlacedPart& b) {
  const Vector3d apart = a.centre - b.centre;
  const double distance = apart.norm();
  const Vector3d normal = distance > 0 ? Vector3d(apart / distance) : Vector3d::UnitZ();
  const double gap = distance - a.size.x() - b.size.x();
  return {a.body, b.body, b.centre + (b.size.x() + gap / 2) * normal, normal, gap};
}

/// The point is on the box.
Touch between_ball_and_box(const PlacedPart& ball, const PlacedPart& box) {
  const Vector3d centre = box.axes.transpose() * (ball.centre - box.centre);
  Vector3d nearest = centre.cwiseMax(-box.size).cwiseMin(box.size);
  Vector3d normal = centre - nearest;
  double distance = normal.norm();
  if (distance > 0) {
    normal /= distance;
  } else {  // inside: out of the nearest face
    Eigen::Index axis = 0;
    distance = -(box.size - centre.cwiseAbs()).minCoeff(&axis);
    normal = std::copysign(1.0, centre(axis)) * Vector3d::Unit(axis);
    nearest(axis) = normal(axis) * box.size(axis);
  }
  return {ball.body, box.body, box.centre + box.axes * nearest, box.axes * normal, distance - ball.size.x()};
}

/// How far a point is from the face of a box that looks most along a direction.
double distance_to_face(const PlacedPart& box, const Vector3d& direction, const Vector3d& point) {
  const Vector3d along = box.axes.transpose() * direction;
  Eigen::Index axis = 0;
  along.cwiseAbs().maxCoeff(&axis);
  return std::abs(std::copysign(box.size(axis), along(axis)) - box.axes.col(axis).dot(point - box.centre));
}

PlacedPart grown(PlacedPart part, double by) {
  part.size.array() += by;
  return part;
}

/// Gives the smaller box the axes of the larger one where they are parallel to rounding. The axis across two edges that
/// are almost parallel is rounding error alone, which can separate boxes that overlap.
void align(PlacedPart& a, PlacedPart& b) {
  constexpr double kParallel = 1e-9;  // rad: a nanometre at a box of 1 m
  const Eigen::Matrix3d turn = a.axes.transpose() * b.axes;
  const Eigen::Matrix3d whole = turn.array().round();
  if (!((turn - whole).cwiseAbs().maxCoeff() < kParallel)) return;
  if (radius(a) < radius(b))
    a.axes = b.axes * whole.transpose();
  else
    b.axes = a.axes * whole;
}

void between_boxes(PlacedPart a, PlacedPart b, const BoxOverlap& overlap, std::vector<Touch>& touches) {
  align(a, b);
  const std::size_t first = touches.size();
  overlap(grown(a, kContactMargin / 2), grown(b, kContactMargin / 2), touches);
  if (touches.size() == first) return;
  const Vector3d way = -kContactMargin * touches[first].normal;
  touches.resize(first);
  PlacedPart pushed = a;
  pushed.centre += way;
  overlap(pushed, b, touches);
  for (std::size_t i = first; i < touches.size(); ++i) {
    Touch& touch = touches[i];
    touch.gap -= way.dot(touch.normal);
    // A point on the box that was pushed goes back with it.
    const double from_a = distance_to_face(pushed, -touch.normal, touch.point);
    const double from_b = distance_to_face(b, touch.normal, touch.point);
    if (from_a + from_b > 0) touch.point -= from_b / (from_a + from_b) * way;
  }
}

}  // namespace

std::vector<Touch> close_parts(const Scene& scene, const std::vector<Pose>& poses, const BoxOverlap& overlap) {
  const std::vector<PlacedPart> parts = placed_parts(scene, poses);
  std::vector<Touch> touches;
  for (std::size_t i = parts.size(); i-- > 0;) {  // as ODE: the last part first
    for (std::size_t j = i; j-- > 0;) {
      const PlacedPart& a = parts[i];
      const PlacedPart& b = parts[j];
      if (a.body == b.body || scene.bodies[a.body].mass + scene.bodies[b.body].mass == 0) continue;
      if (!((a.centre - b.centre).norm() <= radius(a) + radius(b) + kContactMargin)) continue;
      const bool ball_a = a.kind == Part::Kind::kSphere;
      const bool ball_b = b.kind == Part::Kind::kSphere;
      if (!ball_a && !ball_b)
        between_boxes(a, b, overlap, touches);
      else if (ball_a)
        touches.push_back(ball_b ? between_balls(a, b) : between_ball_and_box(a, b));
      else
        touches.push_back(between_ball_and_box(b, a));
    }
  }
  std::erase_if(touches, [](const Touch& touch) { return !(touch.gap <= kContactMargin); });
  return touches;
}

}  // namespace lcpbench::capture
