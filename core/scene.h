#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "core/contact_problem.h"

namespace lcpbench {

/// A free rigid body. Everything is in world axes at the instant of the impact.
struct RigidBody {
  double mass = 1.0;                                           ///< [kg], > 0
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Identity();       ///< about the centre of mass [kg m^2], SPD
  Eigen::Vector3d position = Eigen::Vector3d::Zero();          ///< centre of mass [m]
  Eigen::Vector3d linear_velocity = Eigen::Vector3d::Zero();   ///< [m/s]
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< [rad/s]
};

/// A point contact that pushes body_a along `normal` and body_b (or the immovable world) against it.
struct RigidContact {
  static constexpr int kWorld = -1;

  int body_a = 0;
  int body_b = kWorld;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();     ///< [m]
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();   ///< from body_b into body_a; taken as it is, not normalised
  Eigen::Vector3d tangent = Eigen::Vector3d::UnitX();  ///< first friction direction; the second is normal x tangent
  double mu = 0.0;                                     ///< friction coefficient >= 0, 0 without edges
  int edges = 0;                                       ///< 0 (frictionless) or 4: directions t1, t2, -t1, -t2
  double b = 0.0;  ///< offset of the contact's normal row [m/s]: restitution, gap / h, a correction of positions
  double compliance_n = 0.0;          ///< r_n >= 0 [m/s per N s], see ContactProblem
  double compliance_t = 0.0;          ///< r_t >= 0, 0 without edges
  Eigen::Vector2d offset_t = Eigen::Vector2d::Zero();  ///< offset of the velocity along both tangents [m/s]
};

/// Rigid bodies and their contacts: plain data, all that an engine adapter needs.
struct RigidScene {
  std::vector<RigidBody> bodies;
  std::vector<RigidContact> contacts;
};

/// The contact problem of a scene: ngc = 6 per body (linear, then angular velocity), block inertia diag(m I, inertia),
/// sparse N and D, b where a contact has an offset, compliance where one is soft. A contact row on body b is [n; r x n]
/// with r = point - position, negated on body_b. Exact if no difference or product of the data needs more than 53 bits.
/// O(bodies + contacts). @pre bodies of contacts exist, edges are 0 or 4; not checked here, see check_scene()
ContactProblem contact_problem(const RigidScene& scene);

}  // namespace lcpbench
