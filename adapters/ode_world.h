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

/// Bodies and frictionless contacts, with error reduction, damping, gravity and gyroscopic terms off: a step of length
/// 1 s solves exactly the scene's frictionless LCP, with M + cfm I for M.
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

  /// Force on body_a along the contact's normal, per unit of the normal: the impulse of a step of 1 s.
  double normal_impulse(std::size_t contact, const Eigen::Vector3d& normal) const;

 private:
  void add(const RigidBody& body);
  void add(const RigidContact& contact);

  dWorldID id_;
  dJointGroupID joints_;
  std::vector<dBodyID> bodies_;
  std::vector<dJointID> contacts_;
  std::vector<dJointFeedback> feedback_;
};

}  // namespace lcpbench
