#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "adapters/capture/engine.h"

namespace lcpbench::capture {

/// A part of a body where a step finds it.
struct PlacedPart {
  std::size_t body = 0;  ///< in Scene::bodies
  Part::Kind kind = Part::Kind::kBox;
  Eigen::Vector3d size = Eigen::Vector3d::Ones();  ///< as Part::size
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< of the part, in its columns
};

struct Touch {
  std::size_t body_a = 0;  ///< in Scene::bodies
  std::size_t body_b = 0;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< from b into a
  double gap = 0;                                     ///< [m], negative: penetration
};

/// An engine's detection for two boxes: appends their contacts, none where they do not overlap. The points are on a
/// face of either box, or between two edges.
using BoxOverlap = std::function<void(const PlacedPart& a, const PlacedPart& b, std::vector<Touch>& touches)>;

/// Contacts up to a gap of kContactMargin between the parts of a scene, by a detection that finds overlaps only. Boxes
/// that are open overlap once one of them is pushed by the margin along the normal, which two boxes that are larger by
/// the margin tell. Points and gaps are those of the boxes as they are. Contacts of balls have closed forms. Every pair
/// of parts is looked at: n^2 / 2 distances.
/// @param poses  of the parts: Snapshot::poses
std::vector<Touch> close_parts(const Scene& scene, const std::vector<Pose>& poses, const BoxOverlap& overlap);

}  // namespace lcpbench::capture
