#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <ode/ode.h>

#include "adapters/capture/close_parts.h"
#include "adapters/capture/engine.h"
#include "core/timed_solve.h"

namespace lcpbench::capture {
namespace {

constexpr int kMostContacts = 8;  // of a pair of parts

using OdeVector = std::array<dReal, 4>;
OdeVector ode_vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z(), 0}; }

/// A BoxOverlap. ODE's normal points from its first box to its second.
void overlap(const PlacedPart& a, const PlacedPart& b, std::vector<Touch>& touches) {
  using Axes = Eigen::Matrix<dReal, 3, 4, Eigen::RowMajor>;
  const auto matrix = [](const PlacedPart& part) {
    return Axes((Axes() << part.axes, Eigen::Vector3d::Zero()).finished());
  };
  std::array<dContactGeom, kMostContacts> found{};
  dVector3 normal;
  dReal depth = 0;
  int code = 0;
  const int count =
      dBoxBox(ode_vector(a.centre).data(), matrix(a).data(), ode_vector(2 * a.size).data(), ode_vector(b.centre).data(),
              matrix(b).data(), ode_vector(2 * b.size).data(), normal, &depth, &code, kMostContacts, found.data(),
              sizeof(dContactGeom));
  for (int i = 0; i < count; ++i) {
    const dContactGeom& contact = found[static_cast<std::size_t>(i)];
    touches.push_back({a.body, b.body, Eigen::Map<const Eigen::Vector3d>(contact.pos),
                       -Eigen::Map<const Eigen::Vector3d>(normal), -contact.depth});
  }
}

class OdeEngine final : public Engine {
 public:
  explicit OdeEngine(const Scene& scene) : Engine(scene, "ODE", LCPBENCH_ENGINE_VERSION) {
    dInitODE2(0);
    dAllocateODEDataForThread(static_cast<unsigned>(dAllocateMaskAll));
    world_ = dWorldCreate();
    space_ = dSimpleSpaceCreate(nullptr);
    joints_ = dJointGroupCreate(0);
    dWorldSetAutoDisableFlag(world_, 0);
    dWorldSetStepIslandsProcessingMaxThreadCount(world_, 1);
    dRandSetSeed(1);
    if (scene_.cfm >= 0) dWorldSetCFM(world_, scene_.cfm);
    if (scene_.erp >= 0) dWorldSetERP(world_, scene_.erp);
    if (scene_.sweeps > 0) dWorldSetQuickStepNumIterations(world_, scene_.sweeps);
    for (const Body& body : scene_.bodies) add(body);
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      if (scene_.bodies[i].joint) add_joint(i);
    }
    for (const Loop& loop : scene_.loops) add_loop(loop);
    for (Held& each : held_) dJointSetFeedback(each.joint, &each.feedback);
  }
  ~OdeEngine() override {
    dJointGroupDestroy(joints_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
    dCloseODE();
  }

  void step(long index, Snapshot& snapshot, const VelocitySolver& loop) override {
    snapshot = {};
    apply_forces(index, snapshot);
    snapshot_ = &snapshot;
    contact_joints_.clear();
    if (loop) {
      for (const Touch& touch : close_parts(scene_, snapshot.poses, overlap)) add(touch);
    } else {
      dSpaceCollide(space_, this,
                    [](void* engine, dGeomID a, dGeomID b) { static_cast<OdeEngine*>(engine)->near(a, b); });
    }
    if (!held_.empty()) look_at_joints(snapshot);
    if (loop) {
      move_on(loop(snapshot), snapshot);
    } else {
      solve(snapshot);
    }
  }

 private:
  void solve(Snapshot& snapshot) {
    // ODE keeps pointers to the feedback, so its memory must not move any more.
    std::vector<dJointFeedback> feedback(contact_joints_.size());
    for (std::size_t i = 0; i < feedback.size(); ++i) dJointSetFeedback(contact_joints_[i], &feedback[i]);
    const double start = thread_cpu_clock_s();
    dWorldQuickStep(world_, scene_.step);
    snapshot.solve_s = thread_cpu_clock_s() - start;
    for (std::size_t i = 0; i < feedback.size(); ++i) {
      ContactState& contact = snapshot.contacts[i];
      // The force on the joint's first body, which is body_a unless that is the world.
      const double sign = contact.body_a == kWorld ? -1 : 1;
      const Eigen::Vector3d force = sign * Eigen::Map<const Eigen::Vector3d>(feedback[i].f1);
      contact.impulse = scene_.step * in_axes_of(contact, force);
    }
    for (const Held& each : held_) {
      if (each.count == 0) continue;
      set_impulses(scene_.step * Eigen::Map<const Eigen::Vector3d>(each.feedback.f1),
                   scene_.step * Eigen::Map<const Eigen::Vector3d>(each.feedback.t1),
                   std::span(snapshot.rows).subspan(each.first, each.count));
    }
    snapshot.has_impulses = true;
    dJointGroupEmpty(joints_);
    keep_velocities(snapshot);
  }

  /// Without joints and forces, a step of ODE moves the bodies along their velocities.
  void move_on(const Eigen::VectorXd& velocity, const Snapshot& snapshot) {
    for (const dBodyID body : moving_) {
      dBodySetForce(body, 0, 0, 0);
      dBodySetTorque(body, 0, 0, 0);
    }
    for (const Held& each : held_) dJointDisable(each.joint);
    set_velocities(moving_velocity(velocity, snapshot, scene_.step));
    dWorldQuickStep(world_, scene_.step);
    if (snapshot.correction.size() > 0) set_velocities(velocity);
  }

  void set_velocities(const Eigen::VectorXd& velocity) {
    for (std::size_t i = 0; i < moving_.size(); ++i) {
      const double* v = velocity.data() + 6 * i;
      dBodySetLinearVel(moving_[i], v[0], v[1], v[2]);
      dBodySetAngularVel(moving_[i], v[3], v[4], v[5]);
    }
  }

  /// What a geometry belongs to: the body of the scene, and its index among the moving ones.
  struct Owner {
    std::size_t body = 0;
    int moving = kWorld;
  };

  void add(const Body& body) {
    auto owner = std::make_unique<Owner>(Owner{owners_.size(), kWorld});
    dBodyID id = nullptr;
    const dQuaternion q{body.orientation.w(), body.orientation.x(), body.orientation.y(), body.orientation.z()};
    if (body.mass > 0) {
      owner->moving = static_cast<int>(moving_.size());
      id = dBodyCreate(world_);
      dMass mass;
      dMassSetParameters(&mass, body.mass, 0, 0, 0, body.inertia.x(), body.inertia.y(), body.inertia.z(), 0, 0, 0);
      dBodySetMass(id, &mass);
      dBodySetPosition(id, body.position.x(), body.position.y(), body.position.z());
      dBodySetQuaternion(id, q);
      dBodySetLinearVel(id, body.linear_velocity.x(), body.linear_velocity.y(), body.linear_velocity.z());
      dBodySetAngularVel(id, body.angular_velocity.x(), body.angular_velocity.y(), body.angular_velocity.z());
      dBodySetGyroscopicMode(id, 0);  // its torque is applied with the other forces
      moving_.push_back(id);
    }
    for (const Part& part : body.parts) {
      const dGeomID geom = part.kind == Part::Kind::kSphere
                               ? dCreateSphere(space_, part.size.x())
                               : dCreateBox(space_, 2 * part.size.x(), 2 * part.size.y(), 2 * part.size.z());
      dGeomSetData(geom, owner.get());
      if (id != nullptr) {
        dGeomSetBody(geom, id);
        dGeomSetOffsetPosition(geom, part.offset.x(), part.offset.y(), part.offset.z());
      } else {
        const Eigen::Vector3d at = body.position + body.orientation * part.offset;
        dGeomSetPosition(geom, at.x(), at.y(), at.z());
        dGeomSetQuaternion(geom, q);
      }
    }
    ids_.push_back(id);
    owners_.push_back(std::move(owner));
  }

  /// A joint of ODE's between bodies of the scene, of which the first moves.
  struct Held {
    dJointID joint;
    std::size_t first_body, second_body;
    dJointFeedback feedback{};
    std::size_t first = 0, count = 0;  ///< its rows in the snapshot
  };

  void hold(dJointID joint, std::size_t first, std::size_t second) {
    dJointAttach(joint, ids_[first], ids_[second]);
    held_.push_back({joint, first, second});
  }

  /// The motor or dry friction is a joint of its own: in one with limits it would be a mere force at the limits.
  void add_joint(std::size_t index) {
    const Joint& of = *scene_.bodies[index].joint;
    const auto parent = static_cast<std::size_t>(of.parent);
    constexpr int kWithFirstBody = 1;
    const dJointID joint = of.slides ? dJointCreateSlider(world_, nullptr) : dJointCreateHinge(world_, nullptr);
    hold(joint, index, parent);
    if (of.slides) {
      dJointSetSliderAxis(joint, of.axis.x(), of.axis.y(), of.axis.z());
      dJointSetSliderParam(joint, dParamLoStop, of.lower);
      dJointSetSliderParam(joint, dParamHiStop, of.upper);
    } else {
      dJointSetHingeAnchor(joint, of.anchor.x(), of.anchor.y(), of.anchor.z());
      dJointSetHingeAxis(joint, of.axis.x(), of.axis.y(), of.axis.z());
      dJointSetHingeParam(joint, dParamLoStop, of.lower);
      dJointSetHingeParam(joint, dParamHiStop, of.upper);
    }
    if (of.effort == 0) return;
    const dJointID motor = of.slides ? dJointCreateLMotor(world_, nullptr) : dJointCreateAMotor(world_, nullptr);
    hold(motor, index, parent);
    if (of.slides) {
      dJointSetLMotorNumAxes(motor, 1);
      dJointSetLMotorAxis(motor, 0, kWithFirstBody, of.axis.x(), of.axis.y(), of.axis.z());
      dJointSetLMotorParam(motor, dParamFMax, of.effort);
      dJointSetLMotorParam(motor, dParamVel, of.speed);
    } else {
      dJointSetAMotorNumAxes(motor, 1);
      dJointSetAMotorAxis(motor, 0, kWithFirstBody, of.axis.x(), of.axis.y(), of.axis.z());
      dJointSetAMotorParam(motor, dParamFMax, of.effort);
      dJointSetAMotorParam(motor, dParamVel, of.speed);
    }
  }

  void add_loop(const Loop& loop) {
    const dJointID joint = dJointCreateBall(world_, nullptr);
    hold(joint, static_cast<std::size_t>(loop.first), static_cast<std::size_t>(loop.second));
    dJointSetBallAnchor(joint, loop.anchor.x(), loop.anchor.y(), loop.anchor.z());
  }

  void look_at_joints(Snapshot& snapshot) {
    int loops = 0;
    for (Held& each : held_) {
      each.first = snapshot.rows.size();
      const int type = dJointGetType(each.joint);
      if (type == dJointTypeHinge) {
        look_at_hinge(each, snapshot);
      } else if (type == dJointTypeSlider) {
        look_at_slide(each, snapshot);
      } else if (type != dJointTypeBall) {
        look_at_motor(each, snapshot);
      } else {
        dVector3 first, second;
        dJointGetBallAnchor(each.joint, first);
        dJointGetBallAnchor2(each.joint, second);
        add_point(each, first, second, fmt::format("connect equality {}", loops++), snapshot);
      }
      each.count = snapshot.rows.size() - each.first;
    }
    make_blocks(snapshot);
  }

  Eigen::Vector3d centre(std::size_t body) const {
    if (ids_[body] == nullptr) return Eigen::Vector3d::Zero();
    return Eigen::Map<const Eigen::Vector3d>(dBodyGetPosition(ids_[body]));
  }

  /// A row of ODE's, J v+ + cfm f / h = c with f the impulse. Hard equality constraints keep the error of positions
  /// that they have, as contacts keep their penetration. [ODE, joints/joint.cpp, quickstep.cpp]
  void add_row(RowState row, double c, Snapshot& snapshot) const {
    if (!scene_.soft.empty()) {
      row.offset = -c;
      row.compliance = dWorldGetCFM(world_) / scene_.step;
    }
    snapshot.rows.push_back(std::move(row));
  }

  void add_point(const Held& held, const dReal* first, const dReal* second, const std::string& name,
                 Snapshot& snapshot) const {
    const Eigen::Map<const Eigen::Vector3d> p(first), q(second);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d axis = Eigen::Vector3d::Unit(k);
      add_row(row_of(held, axis, (p - centre(held.first_body)).cross(axis), (q - centre(held.second_body)).cross(axis),
                     numbered(name, k + 1)),
              dWorldGetERP(world_) / scene_.step * (q - p)(k), snapshot);
    }
  }

  RowState row_of(const Held& held, const Eigen::Vector3d& linear, const Eigen::Vector3d& angular_first,
                  const Eigen::Vector3d& angular_second, const std::string& name) const {
    return row_between(owners_[held.first_body]->moving, owners_[held.second_body]->moving, linear, angular_first,
                       angular_second, name);
  }

  /// Of the velocity at which the first body turns about an axis, as the second sees it.
  RowState row_about(const Held& held, const Eigen::Vector3d& axis, const std::string& name) const {
    return row_of(held, Eigen::Vector3d::Zero(), axis, axis, name);
  }

  Eigen::Quaterniond axes_of(std::size_t body) const {
    return ids_[body] == nullptr ? scene_.bodies[body].orientation : pose(ids_[body]).rotation;
  }

  Eigen::Vector3d axis_in(std::size_t body, const Eigen::Vector3d& axis) const {
    return axes_of(body) * (scene_.bodies[body].orientation.conjugate() * axis);
  }

  void look_at_hinge(const Held& held, Snapshot& snapshot) const {
    const Joint& hinge = *scene_.bodies[held.first_body].joint;
    dVector3 first, second;
    dJointGetHingeAnchor(held.joint, first);
    dJointGetHingeAnchor2(held.joint, second);
    const std::string name = fmt::format("hinge equality j{}", held.first_body);
    add_point(held, first, second, name, snapshot);
    const double rate = dWorldGetERP(world_) / scene_.step;
    const Eigen::Vector3d axis = axis_in(held.first_body, hinge.axis);
    const Eigen::Vector3d error = axis.cross(axis_in(held.second_body, hinge.axis));
    const Eigen::Vector3d across = tangent_to(axis);
    add_row(row_about(held, across, numbered(name, 4)), rate * error.dot(across), snapshot);
    const Eigen::Vector3d other = axis.cross(across);
    add_row(row_about(held, other, numbered(name, 5)), rate * error.dot(other), snapshot);
    add_limit(row_about(held, axis, ""), dJointGetHingeAngle(held.joint), held, snapshot);
  }

  /// Both bodies turn alike, and move alike across the axis, at the place halfway between their centres; a body on the
  /// world, at its own. [ODE, joints/slider.cpp]
  void look_at_slide(const Held& held, Snapshot& snapshot) const {
    const Joint& of = *scene_.bodies[held.first_body].joint;
    const std::string name = fmt::format("slide equality j{}", held.first_body);
    const double rate = dWorldGetERP(world_) / scene_.step;
    const auto turn_of = [&](std::size_t body) { return axes_of(body) * scene_.bodies[body].orientation.conjugate(); };
    Eigen::Quaterniond error = turn_of(held.second_body) * turn_of(held.first_body).conjugate();
    if (error.w() < 0) error.coeffs() *= -1;
    for (int k = 0; k < 3; ++k) {
      add_row(row_about(held, Eigen::Vector3d::Unit(k), numbered(name, k + 1)), 2 * rate * error.vec()(k), snapshot);
    }
    const Eigen::Vector3d axis = axis_in(held.first_body, of.axis), across = tangent_to(axis);
    const Body& second = scene_.bodies[held.second_body];
    const Eigen::Vector3d wanted =
        (ids_[held.second_body] == nullptr ? second.position : centre(held.second_body)) +
        axis_in(held.second_body, scene_.bodies[held.first_body].position - second.position);
    int count = 3;
    for (const Eigen::Vector3d& direction : {across, Eigen::Vector3d(axis.cross(across))}) {
      add_row(row_along(held, direction, numbered(name, ++count)),
              rate * direction.dot(wanted - centre(held.first_body)), snapshot);
    }
    add_limit(row_along(held, axis, ""), dJointGetSliderPosition(held.joint), held, snapshot);
  }

  /// Of the velocity of the first body along a direction, as the second sees it.
  RowState row_along(const Held& held, const Eigen::Vector3d& direction, const std::string& name) const {
    if (ids_[held.second_body] == nullptr) {
      return row_of(held, direction, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), name);
    }
    const Eigen::Vector3d half = (centre(held.second_body) - centre(held.first_body)) / 2;
    return row_of(held, direction, half.cross(direction), -half.cross(direction), name);
  }

  void add_limit(RowState limit, double position, const Held& held, Snapshot& snapshot) const {
    const Joint& of = *scene_.bodies[held.first_body].joint;
    const bool at_lower = position <= of.lower;
    if (!at_lower && position < of.upper) return;
    limit.name = fmt::format("{} limit j{}", of.kind(), held.first_body);
    (at_lower ? limit.lower : limit.upper) = 0;
    const double beyond = position - (at_lower ? of.lower : of.upper);
    add_row(std::move(limit), -dWorldGetERP(world_) / scene_.step * beyond, snapshot);
  }

  void look_at_motor(const Held& held, Snapshot& snapshot) const {
    const Joint& of = *scene_.bodies[held.first_body].joint;
    const std::string name = fmt::format("{} {} j{}", of.kind(), of.speed == 0 ? "friction" : "motor", held.first_body);
    const Eigen::Vector3d axis = axis_in(held.first_body, of.axis);
    RowState row = of.slides ? row_along(held, axis, name) : row_about(held, axis, name);
    row.upper = scene_.step * of.effort;
    row.lower = -row.upper;
    row.offset = -of.speed;
    add_row(std::move(row), of.speed, snapshot);
  }

  static Pose pose(dBodyID id) {
    const dReal* q = dBodyGetQuaternion(id);
    return {Eigen::Map<const Eigen::Vector3d>(dBodyGetPosition(id)), {q[0], q[1], q[2], q[3]}};
  }

  /// Of the controllers at the hinges, on each body.
  std::vector<Eigen::Vector3d> controller_torques(long index) const {
    std::vector<Eigen::Vector3d> torques(ids_.size(), Eigen::Vector3d::Zero());
    for (const Held& each : held_) {
      if (dJointGetType(each.joint) != dJointTypeHinge) continue;
      const Joint& hinge = *scene_.bodies[each.first_body].joint;
      const double angle = dJointGetHingeAngle(each.joint), rate = dJointGetHingeAngleRate(each.joint);
      const double torque = controller_torque(hinge, angle, rate, static_cast<double>(index) * scene_.step);
      const Eigen::Vector3d along = torque * axis_in(each.first_body, hinge.axis);
      torques[each.first_body] += along;
      torques[each.second_body] -= along;
    }
    return torques;
  }

  void apply_forces(long index, Snapshot& snapshot) {
    const std::vector<Eigen::Vector3d> torques = controller_torques(index);
    std::vector<Pose> poses;
    for (std::size_t i = 0; i < ids_.size(); ++i) {
      const Body& body = scene_.bodies[i];
      if (ids_[i] == nullptr) {
        poses.push_back({body.position, body.orientation});
        continue;
      }
      poses.push_back(pose(ids_[i]));
      const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> R(dBodyGetRotation(ids_[i]));
      BodyState state;
      state.mass = body.mass;
      state.inertia = world_inertia(R.leftCols<3>(), body.inertia);
      state.position = poses.back().position;
      state.linear_velocity = Eigen::Map<const Eigen::Vector3d>(dBodyGetLinearVel(ids_[i]));
      state.angular_velocity = Eigen::Map<const Eigen::Vector3d>(dBodyGetAngularVel(ids_[i]));
      const Eigen::Vector3d force = force_on(body, index);
      const Eigen::Vector3d torque =
          gyroscopic_torque(state.inertia, state.angular_velocity, scene_.step) + torques[i];
      dBodyAddForce(ids_[i], force.x(), force.y(), force.z());
      dBodyAddTorque(ids_[i], torque.x(), torque.y(), torque.z());
      state.accelerate(force, torque, scene_.step);
      snapshot.bodies.push_back(state);
    }
    snapshot.poses = part_poses(scene_, poses);
  }

  void near(dGeomID first, dGeomID second) {
    const Owner& a = *static_cast<const Owner*>(dGeomGetData(first));
    const Owner& b = *static_cast<const Owner*>(dGeomGetData(second));
    if (scene_.root(a.body) == scene_.root(b.body) || (a.moving == kWorld && b.moving == kWorld)) return;
    std::array<dContact, kMostContacts> found{};
    const int count = dCollide(first, second, kMostContacts, &found[0].geom, sizeof(dContact));
    for (int i = 0; i < count; ++i) add(found[static_cast<std::size_t>(i)], a, b);
  }

  /// Of ODE's step.
  void add(dContact& data, const Owner& a, const Owner& b) {
    add({a.body, b.body, Eigen::Map<const Eigen::Vector3d>(data.geom.pos),
         Eigen::Map<const Eigen::Vector3d>(data.geom.normal), -data.geom.depth});
    ContactState& contact = snapshot_->contacts.back();
    data.surface.mode = dContactFDir1 | dContactApprox1 | (scene_.restitution > 0 ? dContactBounce : 0);
    data.surface.mu = scene_.mu;
    data.surface.bounce = scene_.restitution;
    data.surface.bounce_vel = 0.2;
    for (int k = 0; k < 3; ++k) data.fdir1[k] = contact.tangent(k);
    if (!scene_.soft.empty()) soften(contact);
    const dJointID joint = dJointCreateContact(world_, joints_, &data);
    dJointAttach(joint, ids_[a.body], ids_[b.body]);
    contact_joints_.push_back(joint);
  }

  void add(const Touch& touch) {
    if (scene_.root(touch.body_a) == scene_.root(touch.body_b)) return;
    const int a = owners_[touch.body_a]->moving;
    const int b = owners_[touch.body_b]->moving;
    const Eigen::Vector3d approach = velocity(a, touch.point) - velocity(b, touch.point);
    if (waits_to_bounce(scene_, touch.gap, approach.dot(touch.normal))) return;
    ContactState contact =
        lcpbench::capture::touch(scene_, touch.body_a, touch.body_b, touch.point, touch.normal, touch.gap, approach);
    contact.body_a = a;
    contact.body_b = b;
    const Pose frame = pose(moving_[static_cast<std::size_t>(a == kWorld ? b : a)]);
    contact.local = frame.rotation.conjugate() * (contact.point - frame.position);
    snapshot_->contacts.push_back(contact);
  }

  /// ODE's rows, with f the impulse (ODE solves for the force f / h): J v+ + cfm f / h = c. Along the normal c is the
  /// larger of erp depth / h and the velocity of the bounce, along both directions of friction c = 0.
  /// [ODE, joints/contact.cpp, quickstep.cpp]
  void soften(ContactState& contact) const {
    const double h = scene_.step;
    contact.offset = std::min(contact.offset, dWorldGetERP(world_) * contact.gap / h);
    contact.compliance_n = contact.compliance_t = dWorldGetCFM(world_) / h;
    set_square_friction(contact.tangent, contact);
  }

  /// Of a point, without the forces of this step.
  Eigen::Vector3d velocity(int moving, const Eigen::Vector3d& point) const {
    if (moving == kWorld) return Eigen::Vector3d::Zero();
    dVector3 result;
    dBodyGetPointVel(moving_[static_cast<std::size_t>(moving)], point.x(), point.y(), point.z(), result);
    return Eigen::Map<const Eigen::Vector3d>(result);
  }

  void keep_velocities(Snapshot& snapshot) const {
    snapshot.velocity_after.resize(static_cast<Eigen::Index>(6 * moving_.size()));
    for (std::size_t i = 0; i < moving_.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(6 * i);
      snapshot.velocity_after.segment<3>(at) = Eigen::Map<const Eigen::Vector3d>(dBodyGetLinearVel(moving_[i]));
      snapshot.velocity_after.segment<3>(at + 3) = Eigen::Map<const Eigen::Vector3d>(dBodyGetAngularVel(moving_[i]));
    }
  }

  dWorldID world_ = nullptr;
  dSpaceID space_ = nullptr;
  dJointGroupID joints_ = nullptr;
  std::vector<dBodyID> ids_;  ///< of the scene's bodies; nullptr for the world's
  std::vector<dBodyID> moving_;
  std::vector<std::unique_ptr<Owner>> owners_;
  std::vector<dJointID> contact_joints_;  ///< of this step
  std::vector<Held> held_;
  Snapshot* snapshot_ = nullptr;
};

}  // namespace

std::unique_ptr<Engine> make_engine(const Scene& scene, const std::string& model) {
  require_built_scene(scene, model, "ODE");
  return std::make_unique<OdeEngine>(scene);
}

}  // namespace lcpbench::capture
