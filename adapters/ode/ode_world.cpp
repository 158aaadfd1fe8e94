#include "adapters/ode/ode_world.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <numbers>
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

bool has_friction(const RigidContact& contact) { return contact.edges > 0 && contact.mu > 0; }

Eigen::Vector3d second_tangent(const RigidContact& contact) { return contact.normal.cross(contact.tangent); }

/// The first of ODE's two friction directions; the second is normal x this.
Eigen::Vector3d turned_tangent(const RigidContact& contact) {
  return std::numbers::sqrt2 / 2 * (contact.tangent + second_tangent(contact));
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
  for (int k = 0; k < 3; ++k) {
    data.geom.pos[k] = contact.point(k);
    data.geom.normal[k] = contact.normal(k);
  }
  if (has_friction(contact)) {
    data.surface.mode = dContactFDir1 | dContactApprox1;
    data.surface.mu = contact.mu / std::numbers::sqrt2;
    const Eigen::Vector3d first = turned_tangent(contact);
    for (int k = 0; k < 3; ++k) data.fdir1[k] = first(k);
  }
  if (contact.b != 0) {
    data.surface.mode |= dContactMotionN;
    data.surface.motionN = -contact.b;
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

void OdeWorld::read(const RigidScene& scene, Vector& z) const {
  Index friction = static_cast<Index>(scene.contacts.size());
  Index lambda = friction;
  for (const RigidContact& contact : scene.contacts) lambda += contact.edges;
  for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
    const RigidContact& contact = scene.contacts[i];
    z(static_cast<Index>(i)) = normal_impulse(i, contact.normal);
    if (contact.edges == 0) continue;
    read_friction(scene, i, z, friction, lambda);
    friction += contact.edges;
    ++lambda;
  }
}

double OdeWorld::normal_impulse(std::size_t contact, const Eigen::Vector3d& normal) const {
  return Eigen::Map<const Eigen::Vector3d>(feedback_[contact].f1).dot(normal) / normal.squaredNorm();
}

void OdeWorld::read_friction(const RigidScene& scene, std::size_t index, Vector& z, Index friction,
                             Index lambda) const {
  const RigidContact& contact = scene.contacts[index];
  Eigen::Vector2d impulse = Eigen::Vector2d::Zero();  // along t and n x t
  if (has_friction(contact)) {
    // Normals and tangents of a file are orthogonal to 1e-6 only: the force is taken apart along the rows it came from.
    Eigen::Matrix3d rows;
    rows.col(0) = contact.normal;
    rows.col(1) = turned_tangent(contact);
    rows.col(2) = contact.normal.cross(rows.col(1));
    const Eigen::Vector3d parts = rows.inverse() * Eigen::Map<const Eigen::Vector3d>(feedback_[index].f1);
    z(static_cast<Index>(index)) = parts(0);
    impulse = std::numbers::sqrt2 / 2 * Eigen::Vector2d(parts(1) - parts(2), parts(1) + parts(2));
  }
  const Eigen::Vector3d slip =
      velocity(scene, contact.body_a, contact.point) - velocity(scene, contact.body_b, contact.point);
  for (Index k = 0; k < 2; ++k) {
    z(friction + k) = std::max(impulse(k), 0.0);
    z(friction + 2 + k) = std::max(0.0 - impulse(k), 0.0);
  }
  z(lambda) = std::max(std::abs(contact.tangent.dot(slip)), std::abs(second_tangent(contact).dot(slip)));
}

/// After a step, of the point where it was before: the step has moved the bodies.
Eigen::Vector3d OdeWorld::velocity(const RigidScene& scene, int body, const Eigen::Vector3d& point) const {
  if (body == RigidContact::kWorld) return Eigen::Vector3d::Zero();
  const auto b = static_cast<std::size_t>(body);
  const Eigen::Map<const Eigen::Vector3d> linear(dBodyGetLinearVel(bodies_[b]));
  const Eigen::Map<const Eigen::Vector3d> angular(dBodyGetAngularVel(bodies_[b]));
  return linear + angular.cross(point - scene.bodies[b].position);
}

}  // namespace lcpbench
