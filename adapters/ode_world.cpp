#include "adapters/ode_world.h"

#include <cstdarg>
#include <cstdio>
#include <utility>

namespace lcpbench {
namespace {

// ODE reports trouble through process-wide handlers that take no context.
std::string g_message;

void keep_message(int number, const char* format, va_list arguments) {
  char text[200];
  std::vsnprintf(text, sizeof text, format, arguments);
  g_message = "ODE message " + std::to_string(number) + ": " + text;
}

struct OdeLibrary {
  OdeLibrary() {
    dInitODE2(0);
    dAllocateODEDataForThread(static_cast<unsigned>(dAllocateMaskAll));
    dSetMessageHandler(keep_message);
  }
  ~OdeLibrary() { dCloseODE(); }
};

}  // namespace

void start_ode() { static const OdeLibrary library; }

std::string take_ode_message() { return std::exchange(g_message, {}); }

OdeWorld::OdeWorld(const RigidScene& scene, double cfm) : id_(dWorldCreate()), joints_(dJointGroupCreate(0)) {
  dWorldSetGravity(id_, 0, 0, 0);
  dWorldSetERP(id_, 0);
  dWorldSetCFM(id_, cfm);
  dWorldSetContactSurfaceLayer(id_, 0);
  dWorldSetAutoDisableFlag(id_, 0);
  dWorldSetStepIslandsProcessingMaxThreadCount(id_, 1);
  for (const RigidBody& body : scene.bodies) add(body);
  for (const RigidContact& contact : scene.contacts) add(contact);
  feedback_.resize(contacts_.size());  // ODE keeps pointers into it
  for (std::size_t i = 0; i < contacts_.size(); ++i) dJointSetFeedback(contacts_[i], &feedback_[i]);
}

OdeWorld::~OdeWorld() {
  dJointGroupDestroy(joints_);
  dWorldDestroy(id_);
}

void OdeWorld::add(const RigidBody& body) {
  const dBodyID id = dBodyCreate(id_);
  dMass mass;
  const Eigen::Matrix3d& I = body.inertia;
  dMassSetParameters(&mass, body.mass, 0, 0, 0, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
  dBodySetMass(id, &mass);
  dBodySetGyroscopicMode(id, 0);
  bodies_.push_back(id);
}

void OdeWorld::add(const RigidContact& contact) {
  dContact data{};
  data.surface.mode = 0;
  data.surface.mu = 0;
  for (int k = 0; k < 3; ++k) {
    data.geom.pos[k] = contact.point(k);
    data.geom.normal[k] = contact.normal(k);
  }
  const dJointID joint = dJointCreateContact(id_, joints_, &data);
  const dBodyID second =
      contact.body_b == RigidContact::kWorld ? nullptr : bodies_[static_cast<std::size_t>(contact.body_b)];
  dJointAttach(joint, bodies_[static_cast<std::size_t>(contact.body_a)], second);
  contacts_.push_back(joint);
}

void OdeWorld::reset(const RigidScene& scene) {
  constexpr dQuaternion kUpright = {1, 0, 0, 0};
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const RigidBody& body = scene.bodies[i];
    dBodySetPosition(bodies_[i], body.position(0), body.position(1), body.position(2));
    dBodySetQuaternion(bodies_[i], kUpright);  // inertia is given in world axes
    dBodySetLinearVel(bodies_[i], body.linear_velocity(0), body.linear_velocity(1), body.linear_velocity(2));
    dBodySetAngularVel(bodies_[i], body.angular_velocity(0), body.angular_velocity(1), body.angular_velocity(2));
    dBodySetForce(bodies_[i], 0, 0, 0);
    dBodySetTorque(bodies_[i], 0, 0, 0);
  }
}

double OdeWorld::normal_impulse(std::size_t contact, const Eigen::Vector3d& normal) const {
  const dReal* force = feedback_[contact].f1;
  return (force[0] * normal(0) + force[1] * normal(1) + force[2] * normal(2)) / normal.squaredNorm();
}

}  // namespace lcpbench
