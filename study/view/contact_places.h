#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/io/scenes_file.h"

namespace lcpbench {

/// A contact's point and orthonormal directions, in the world: its impulses push the first body, or the body whose rows
/// tell the place, along them.
struct ContactPlace {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d tangent = Eigen::Vector3d::UnitX();
  Eigen::Vector3d second_tangent = Eigen::Vector3d::UnitY();
};

/// The places of a step's contacts; nullopt where the file does not tell.
///
/// A problem of kind `scene` names them, and so may the step. Else a problem of kind `contact` has them in its Jacobian where a contact moves a
/// body with six coordinates of its own, as the root of a robot: its rows are the directions C = [n t1 t2] and the
/// moments [r]x C, in the axes of the world or of the body. They count where r then leads from a pose of the pictures
/// to a point that lies on the surfaces of two shapes, for every such contact of the body.
std::vector<std::optional<ContactPlace>> contact_places(const ScenesHeader& header, const SceneStep& step);

}  // namespace lcpbench
