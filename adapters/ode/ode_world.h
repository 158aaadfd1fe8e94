#pragma once

// Shared by the adapters that give ODE a world: the scene as ODE has it, for a step of 1 s in which force equals
// impulse.

#include <string>
#include <vector>

#include <ode/ode.h>

#include "core/scene.h"

namespace lcpbench {

static_assert(sizeof(dReal) == sizeof(double), "needs ODE in double precision");

/// Starts ODE with the first use; a process keeps it.
void start_ode();

/// What ODE said since this was last called; "" for nothing. ODE reports trouble in no other way.
std::string take_ode_message();

/// Bodies and contacts, with error reduction, damping, gravity and gyroscopic terms off: in a step of length 1 s force
/// equals impulse, and the rows of the step are those of the scene, with cfm added to the diagonal.
///
/// Friction: ODE limits the impulse along each of its two directions, |x_i| <= mu f_N: a square. The pyramid of the
/// scene, |g_1| + |g_2| <= mu f_N along t and n x t, is that square turned by 45 degrees: ODE is given (t + n x t) /
/// sqrt(2) for its first direction, takes n x that for the second, and mu / sqrt(2). A contact with mu = 0 has no
/// friction rows.
///
/// An offset b is a surface that moves along the normal (dContactMotionN): a contact's velocity is to be -b at least.
/// @pre start_ode() was called.
class OdeWorld {
 public:
  OdeWorld(const RigidScene& scene, double cfm);
  ~OdeWorld();
  OdeWorld(const OdeWorld&) = delete;
  OdeWorld& operator=(const OdeWorld&) = delete;

  dWorldID id() const { return id_; }

  /// A step moves the bodies; this puts them back.
  void reset(const RigidScene& scene);

  /// z of the scene's contact problem, after a step: impulses from the forces on the contacts; lambda, which ODE does
  /// not have, from the velocities after the step: the largest slip along a friction direction.
  void read(const RigidScene& scene, Vector& z) const;

 private:
  void add(const RigidBody& body);
  void add(const RigidContact& contact);
  double normal_impulse(std::size_t contact, const Eigen::Vector3d& normal) const;
  void read_friction(const RigidScene& scene, std::size_t contact, Vector& z, Index friction, Index lambda) const;
  Eigen::Vector3d velocity(const RigidScene& scene, int body, const Eigen::Vector3d& point) const;

  dWorldID id_;
  dJointGroupID joints_;
  std::vector<dBodyID> bodies_;
  std::vector<dJointID> contacts_;
  std::vector<dJointFeedback> feedback_;
};

}  // namespace lcpbench
