#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <btBulletDynamicsCommon.h>
#include <fmt/format.h>

#include "adapters/capture/engine.h"
#include "core/timed_solve.h"

static_assert(sizeof(btScalar) == sizeof(double), "needs Bullet's float64 build");

namespace lcpbench::capture {
namespace {

Eigen::Vector3d vector(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
btVector3 vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Eigen::Matrix3d matrix(const btMatrix3x3& m) {
  Eigen::Matrix3d result;
  for (int i = 0; i < 3; ++i) result.row(i) = vector(m.getRow(i));
  return result;
}

Pose pose(const btTransform& transform) {
  const btQuaternion q = transform.getRotation();
  return {vector(transform.getOrigin()), {q.w(), q.x(), q.y(), q.z()}};
}

/// Lets others look at the contacts when they are found and not yet solved.
class World final : public btDiscreteDynamicsWorld {
 public:
  using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;
  /// Called with the contacts found: records them. True: the velocities are set, and Bullet's solver does not run.
  std::function<bool()> solved_by_others;
  double solve_s = 0;

 protected:
  void solveConstraints(btContactSolverInfo& info) override {
    if (solved_by_others()) return;
    const double start = thread_cpu_clock_s();
    btDiscreteDynamicsWorld::solveConstraints(info);
    solve_s = thread_cpu_clock_s() - start;
  }
};

class BulletEngine final : public Engine {
 public:
  explicit BulletEngine(const Scene& scene)
      : Engine(scene, "Bullet", LCPBENCH_ENGINE_VERSION),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_) {
    world_.setGravity(btVector3(0, 0, 0));  // comes with the other forces
    btContactSolverInfo& info = world_.getSolverInfo();
    if (scene_.sweeps > 0) info.m_numIterations = scene_.sweeps;
    if (scene_.cfm >= 0) info.m_globalCfm = scene_.cfm;
    if (scene_.erp >= 0) info.m_erp2 = scene_.erp;
    world_.solved_by_others = [this] {
      look();
      if (*loop_) {
        velocity_ = (*loop_)(*snapshot_);
        set_velocities(moving_velocity(velocity_, *snapshot_, scene_.step));
      }
      return static_cast<bool>(*loop_);
    };
    for (const Body& body : scene_.bodies) add(body);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (scene_.bodies[i].joint) add_joint(i);
      for (std::size_t k = 0; k < i; ++k) {
        if (scene_.root(i) != scene_.root(k)) continue;
        bodies_[i]->setIgnoreCollisionCheck(bodies_[k].get(), true);
        bodies_[k]->setIgnoreCollisionCheck(bodies_[i].get(), true);
      }
    }
    for (const Loop& loop : scene_.loops) add_loop(loop);
  }
  ~BulletEngine() override {
    for (const Held& each : held_) world_.removeConstraint(each.joint.get());
    for (const std::unique_ptr<btRigidBody>& body : bodies_) world_.removeRigidBody(body.get());
  }

  void step(long index, Snapshot& snapshot, const VelocitySolver& loop) override {
    snapshot = {};
    snapshot_ = &snapshot;
    loop_ = &loop;
    touches_.clear();
    apply_forces(index);
    world_.stepSimulation(scene_.step, 0);
    if (!loop) {
      keep_impulses();
      snapshot.solve_s = world_.solve_s;
    }
    // The correction was to move positions only: take it out of the velocities.
    if (snapshot.correction.size() > 0) set_velocities(velocity_);
  }

 private:
  /// A contact, and where its ends are, from the centres of the bodies.
  struct Touch {
    btManifoldPoint* point;
    btVector3 arm_a, arm_b;
  };

  void add(const Body& body) {
    auto compound = std::make_unique<btCompoundShape>();
    for (const Part& part : body.parts) {
      std::unique_ptr<btConvexInternalShape> shape;
      if (part.kind == Part::Kind::kSphere)
        shape = std::make_unique<btSphereShape>(part.size.x());
      else
        shape = std::make_unique<btBoxShape>(vector(part.size));
      // Bullet's margin of 4 cm is more than some bodies are thick. A sphere's margin is its radius.
      if (part.kind == Part::Kind::kBox) shape->setMargin(std::min(0.04, 0.1 * part.size.minCoeff()));
      compound->addChildShape(btTransform(btQuaternion::getIdentity(), vector(part.offset)), shape.get());
      shapes_.push_back(std::move(shape));
    }
    btCollisionShape* shape = compound.get();
    if (body.parts.size() == 1 && body.parts[0].offset.isZero()) shape = shapes_.back().get();
    shapes_.push_back(std::move(compound));
    btRigidBody::btRigidBodyConstructionInfo info(body.mass, nullptr, shape,
                                                  body.mass > 0 ? vector(body.inertia) : btVector3(0, 0, 0));
    const Eigen::Quaterniond& q = body.orientation;
    info.m_startWorldTransform = btTransform(btQuaternion(q.x(), q.y(), q.z(), q.w()), vector(body.position));
    // Bullet multiplies the coefficients of two bodies.
    info.m_friction = std::sqrt(scene_.mu);
    info.m_restitution = std::sqrt(scene_.restitution);
    auto rigid = std::make_unique<btRigidBody>(info);
    rigid->setFlags(0);  // no gyroscopic torque, which comes with the other forces
    rigid->setActivationState(DISABLE_DEACTIVATION);
    rigid->setLinearVelocity(vector(body.linear_velocity));
    rigid->setAngularVelocity(vector(body.angular_velocity));
    rigid->setUserIndex(static_cast<int>(bodies_.size()));
    rigid->setUserIndex2(body.mass > 0 ? moving_++ : kWorld);
    world_.addRigidBody(rigid.get());
    bodies_.push_back(std::move(rigid));
  }

  /// A joint of Bullet's between bodies of the scene, of which the first moves.
  struct Held {
    std::unique_ptr<btTypedConstraint> joint;
    const Joint* of;     ///< none: a loop
    std::string name;    ///< of its body or loop
    std::unique_ptr<btJointFeedback> feedback = std::make_unique<btJointFeedback>();
    std::size_t first = 0, count = 0;  ///< the rows in the snapshot that Bullet solves
  };

  void hold(std::unique_ptr<btTypedConstraint> joint, const Joint* of, std::string name) {
    Held& held = held_.emplace_back(Held{std::move(joint), of, std::move(name)});
    held.joint->setJointFeedback(held.feedback.get());
    world_.addConstraint(held.joint.get(), true);
  }

  /// Hinges without offsets of their frames, Bullet's default, by which the turning of a body is left out at a limit.
  /// And without the bounce that their limits have by default.
  void add_joint(std::size_t index) {
    const Joint& of = *scene_.bodies[index].joint;
    btRigidBody& child = *bodies_[index];
    btRigidBody& parent = *bodies_[static_cast<std::size_t>(of.parent)];
    const Eigen::Vector3d along = Eigen::Vector3d::Unit(of.slides ? 0 : 2);  // in the joint's frame
    const Eigen::Quaterniond q = Eigen::Quaterniond::FromTwoVectors(along, of.axis);
    const btTransform at(btQuaternion(q.x(), q.y(), q.z(), q.w()), vector(of.anchor));
    const btTransform in_child = child.getWorldTransform().inverse() * at;
    const btTransform in_parent = parent.getWorldTransform().inverse() * at;
    if (of.slides) {
      auto joint = std::make_unique<btSliderConstraint>(child, parent, in_child, in_parent, false);
      joint->setLowerLinLimit(of.lower);
      joint->setUpperLinLimit(of.upper);
      joint->setPoweredLinMotor(of.effort > 0);
      joint->setTargetLinMotorVelocity(of.speed);
      joint->setMaxLinMotorForce(of.effort);
      return hold(std::move(joint), &of, fmt::format("j{}", index));
    }
    auto joint = std::make_unique<btHingeConstraint>(child, parent, in_child, in_parent);
    joint->setUseFrameOffset(false);
    constexpr double kSoftness = 0.9, kBias = 0.3, kBounce = 0;  // the first two are Bullet's defaults
    joint->setLimit(of.lower, of.upper, kSoftness, kBias, kBounce);
    if (of.effort > 0) joint->enableAngularMotor(true, of.speed, scene_.step * of.effort);
    hold(std::move(joint), &of, fmt::format("j{}", index));
  }

  void add_loop(const Loop& loop) {
    btRigidBody& first = *bodies_[static_cast<std::size_t>(loop.first)];
    btRigidBody& second = *bodies_[static_cast<std::size_t>(loop.second)];
    const btVector3 anchor = vector(loop.anchor);
    hold(std::make_unique<btPoint2PointConstraint>(first, second, first.getWorldTransform().inverse() * anchor,
                                                   second.getWorldTransform().inverse() * anchor),
         nullptr, std::to_string(&loop - scene_.loops.data()));
  }

  /// Bullet's rows of its joints, with f the impulse: J v+ + cfm M_ii f = rhs. Hard equality constraints keep the error
  /// of positions that they have, as contacts keep their penetration. In Bullet a joint at a limit has no motor and no
  /// dry friction, and its motor is slow before a limit: hard problems have them as they are.
  /// [btSequentialImpulseConstraintSolver.cpp, convertJoint]
  void look_at_joints() {
    long changed = 0;
    for (Held& each : held_) {
      each.first = snapshot_->rows.size();
      each.count = add_rows(each);
      if (each.of == nullptr || each.of->effort == 0 || !scene_.soft.empty()) continue;
      const auto own = std::find_if(snapshot_->rows.begin() + static_cast<std::ptrdiff_t>(each.first),
                                    snapshot_->rows.end(), [](const RowState& row) {
                                      return !std::isinf(row.lower) || !std::isinf(row.upper);
                                    });
      const bool at_limit = std::isinf(own->upper) || std::isinf(own->lower);
      if (at_limit || own->offset != -each.of->speed) ++changed;
      RowState motor = *own;
      motor.upper = scene_.step * each.of->effort;
      motor.lower = -motor.upper;
      motor.offset = -each.of->speed;
      motor.name = motor_name(each);
      if (at_limit) {
        snapshot_->rows.push_back(std::move(motor));
      } else {
        *own = std::move(motor);
      }
    }
    if (changed > 0) {
      snapshot_->notes.push_back(
          fmt::format("motors and dry friction at a limit or before it, which Bullet leaves out or slows: {}",
                      changed));
    }
  }

  static std::string motor_name(const Held& held) {
    return fmt::format("{} {} {}", held.of->kind(), held.of->speed == 0 ? "friction" : "motor", held.name);
  }

  std::size_t add_rows(const Held& held) {
    constexpr int kMostRows = 6;
    constexpr double kNone = std::numeric_limits<double>::infinity();
    struct Row {
      btVector3 linear_a, angular_a, linear_b, angular_b;
      btScalar error, cfm, lower, upper;
    };
    const btContactSolverInfo& info = world_.getSolverInfo();
    std::array<Row, kMostRows> rows;
    const btVector3 zero(0, 0, 0);
    rows.fill({zero, zero, zero, zero, 0, info.m_globalCfm, -SIMD_INFINITY, SIMD_INFINITY});
    btTypedConstraint::btConstraintInfo1 size;
    held.joint->getInfo1(&size);
    btTypedConstraint::btConstraintInfo2 told;
    told.fps = 1 / scene_.step;
    told.erp = info.m_erp;
    told.m_J1linearAxis = rows[0].linear_a;
    told.m_J1angularAxis = rows[0].angular_a;
    told.m_J2linearAxis = rows[0].linear_b;
    told.m_J2angularAxis = rows[0].angular_b;
    told.rowskip = sizeof(Row) / sizeof(btScalar);
    told.m_constraintError = &rows[0].error;
    told.cfm = &rows[0].cfm;
    told.m_lowerLimit = &rows[0].lower;
    told.m_upperLimit = &rows[0].upper;
    told.m_numIterations = info.m_numIterations;
    told.m_damping = info.m_damping;
    held.joint->getInfo2(&told);
    const btRigidBody& a = held.joint->getRigidBodyA();
    const btRigidBody& b = held.joint->getRigidBodyB();
    for (int i = 0; i < size.m_numConstraintRows; ++i) {
      const Row& row = rows[static_cast<std::size_t>(i)];
      const bool equality = row.lower <= -SIMD_INFINITY && row.upper >= SIMD_INFINITY;
      const bool motor = row.lower > -SIMD_INFINITY && row.upper < SIMD_INFINITY;
      const char* const kind = held.of == nullptr ? "connect" : held.of->kind();
      const std::string name = motor      ? motor_name(held)
                               : equality ? numbered(fmt::format("{} equality {}", kind, held.name), i + 1)
                                          : fmt::format("{} limit {}", kind, held.name);
      RowState state = row_between(a.getUserIndex2(), b.getUserIndex2(), vector(row.linear_a), vector(row.angular_a),
                                   vector(-row.angular_b), name);
      state.lower = row.lower <= -SIMD_INFINITY ? -kNone : row.lower;
      state.upper = row.upper >= SIMD_INFINITY ? kNone : row.upper;
      if (motor || !scene_.soft.empty()) state.offset = -row.error;
      if (!scene_.soft.empty()) {
        const auto mobility = [](const btRigidBody& body, const btVector3& linear, const btVector3& angular) {
          return linear.length2() * body.getInvMass() + angular.dot(body.getInvInertiaTensorWorld() * angular);
        };
        state.compliance =
            row.cfm * (mobility(a, row.linear_a, row.angular_a) + mobility(b, row.linear_b, row.angular_b));
      }
      snapshot_->rows.push_back(std::move(state));
    }
    return static_cast<std::size_t>(size.m_numConstraintRows);
  }

  Eigen::Matrix3d inertia(std::size_t i) const {
    return world_inertia(matrix(bodies_[i]->getWorldTransform().getBasis()), scene_.bodies[i].inertia);
  }

  /// Of the step `index`: gravity, the scene's push and the gyroscopic torque, which Bullet's step then adds.
  void apply_forces(long index) {
    for (const Held& each : held_) {
      if (each.of == nullptr || each.of->slides) continue;
      btRigidBody& child = each.joint->getRigidBodyA();
      btRigidBody& parent = each.joint->getRigidBodyB();
      auto& joint = static_cast<btHingeConstraint&>(*each.joint);
      const btVector3 axis = child.getWorldTransform().getBasis() * joint.getAFrame().getBasis().getColumn(2);
      const double speed = axis.dot(child.getAngularVelocity() - parent.getAngularVelocity());
      const double torque = controller_torque(*each.of, joint.getHingeAngle(), speed,
                                              static_cast<double>(index) * scene_.step);
      child.applyTorque(torque * axis);
      parent.applyTorque(-torque * axis);
    }
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      btRigidBody& body = *bodies_[i];
      if (body.getUserIndex2() == kWorld) continue;
      body.applyCentralForce(vector(force_on(scene_.bodies[i], index)));
      body.applyTorque(vector(gyroscopic_torque(inertia(i), vector(body.getAngularVelocity()), scene_.step)));
    }
  }

  void look() {
    std::vector<Pose> poses;
    angular_changes_.clear();
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const btRigidBody& body = *bodies_[i];
      poses.push_back(pose(body.getWorldTransform()));
      if (body.getUserIndex2() == kWorld) continue;
      BodyState state;
      state.mass = scene_.bodies[i].mass;
      state.inertia = inertia(i);
      state.position = poses.back().position;
      state.linear_velocity = vector(body.getLinearVelocity());
      state.angular_velocity = vector(body.getAngularVelocity());
      state.accelerate(vector(body.getTotalForce()), vector(body.getTotalTorque()), scene_.step);
      angular_changes_.push_back(state.angular_change);
      if (scene_.soft.empty())
        snapshot_->bodies.push_back(state);
      else
        snapshot_->blocks.push_back(block_of(state));
    }
    snapshot_->poses = part_poses(scene_, poses);
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(i);
      for (int k = 0; k < manifold.getNumContacts(); ++k) look(manifold, manifold.getContactPoint(k));
    }
    look_at_joints();
    if (!held_.empty() && scene_.soft.empty()) make_blocks(*snapshot_);
  }

  void look(const btPersistentManifold& manifold, btManifoldPoint& point) {
    const btRigidBody& a = *btRigidBody::upcast(manifold.getBody0());
    const btRigidBody& b = *btRigidBody::upcast(manifold.getBody1());
    if (a.getUserIndex2() == kWorld && b.getUserIndex2() == kWorld) return;
    const Eigen::Vector3d where = vector(0.5 * (point.getPositionWorldOnA() + point.getPositionWorldOnB()));
    const btVector3 at = vector(where);
    const btVector3 approach = a.getVelocityInLocalPoint(at - a.getCenterOfMassPosition()) -
                               b.getVelocityInLocalPoint(at - b.getCenterOfMassPosition());
    ContactState contact =
        touch(scene_, static_cast<std::size_t>(a.getUserIndex()), static_cast<std::size_t>(b.getUserIndex()), where,
              vector(point.m_normalWorldOnB), point.getDistance(), vector(approach));
    contact.body_a = a.getUserIndex2();
    contact.body_b = b.getUserIndex2();
    contact.local = vector(contact.body_a == kWorld ? point.m_localPointB : point.m_localPointA);
    touches_.push_back({&point, point.getPositionWorldOnA() - a.getCenterOfMassPosition(),
                        point.getPositionWorldOnB() - b.getCenterOfMassPosition()});
    if (!scene_.soft.empty()) soften(a, b, contact);
    snapshot_->contacts.push_back(contact);
  }

  /// What Bullet's rows have beside J v+ [btSequentialImpulseConstraintSolver.cpp]: cfm / h, a share erp of the
  /// penetration, unless it is so deep that positions alone are corrected (split impulse), and the velocity that
  /// bounces. Friction acts along one direction, which has no cfm.
  void soften(const btRigidBody& a, const btRigidBody& b, ContactState& contact) const {
    const btContactSolverInfo& info = world_.getSolverInfo();
    const Touch& touch = touches_.back();
    const double approach =
        contact.normal.dot(vector(a.getVelocityInLocalPoint(touch.arm_a) - b.getVelocityInLocalPoint(touch.arm_b)));
    const double distance = contact.gap + info.m_linearSlop;
    const bool split = info.m_splitImpulse != 0 && distance <= info.m_splitImpulsePenetrationThreshold;
    contact.offset = (distance > 0 ? 1 : split ? 0 : info.m_erp2) * distance / scene_.step;
    if (approach <= -info.m_restitutionVelocityThreshold)
      contact.offset += touch.point->m_combinedRestitution * approach;
    contact.compliance_n = info.m_globalCfm / scene_.step;
    contact.edges = 2;
  }

  /// Rows of the contact's velocity, that of each body at its own end of the gap.
  static Rows rows(const Touch& touch, const ContactState& contact) {
    Rows rows;
    const auto add = [&](int body, double sign, const Eigen::Vector3d& arm) {
      if (body == kWorld) return;
      for (int k = 0; k < 6; ++k) rows.coordinates.push_back(6 * body + k);
      for (auto [direction, row] :
           {std::pair(&contact.normal, &rows.normal), std::pair(&contact.tangent, &rows.tangent)}) {
        row->conservativeResize(row->size() + 6);
        row->tail<6>() << sign * *direction, sign * arm.cross(*direction);
      }
    };
    add(contact.body_a, 1, vector(touch.arm_a));
    add(contact.body_b, -1, vector(touch.arm_b));
    return rows;
  }

  /// Along the tangent, what the torques of the step add: Bullet's rows of friction leave it out.
  /// [btSequentialImpulseConstraintSolver.cpp, setupFrictionConstraint]
  double velocity_by_torques(const ContactState& contact) const {
    double sum = 0;
    for (std::size_t k = 0; k < contact.rows->coordinates.size(); k += 6) {
      const auto body = static_cast<std::size_t>(contact.rows->coordinates[k] / 6);
      sum += contact.rows->tangent.segment<3>(static_cast<Eigen::Index>(k) + 3).dot(angular_changes_[body]);
    }
    return sum;
  }

  /// Of all moving bodies, with the step's forces in them, which Bullet's own solver would have added.
  /// @param velocity  6 entries a body, in the order of the snapshot
  void set_velocities(const Eigen::VectorXd& velocity) {
    for (const std::unique_ptr<btRigidBody>& body : bodies_) {
      if (body->getUserIndex2() == kWorld) continue;
      const Eigen::Index at = 6 * body->getUserIndex2();
      body->setLinearVelocity(vector(Eigen::Vector3d(velocity.segment<3>(at))));
      body->setAngularVelocity(vector(Eigen::Vector3d(velocity.segment<3>(at + 3))));
    }
  }

  void keep_impulses() {
    for (std::size_t i = 0; i < touches_.size(); ++i) {
      const btManifoldPoint& point = *touches_[i].point;
      ContactState& contact = snapshot_->contacts[i];
      if (!scene_.soft.empty()) {
        contact.tangent = vector(point.m_lateralFrictionDir1);  // of the relative velocity in this step
        contact.rows = rows(touches_[i], contact);
        contact.offset_t(0) = -velocity_by_torques(contact);
      }
      const Eigen::Vector3d impulse = point.m_appliedImpulse * vector(point.m_normalWorldOnB) +
                                      point.m_appliedImpulseLateral1 * vector(point.m_lateralFrictionDir1) +
                                      point.m_appliedImpulseLateral2 * vector(point.m_lateralFrictionDir2);
      contact.impulse = in_axes_of(contact, impulse);
    }
    for (const Held& each : held_) {
      set_impulses(scene_.step * vector(each.feedback->m_appliedForceBodyA),
                   scene_.step * vector(each.feedback->m_appliedTorqueBodyA),
                   std::span(snapshot_->rows).subspan(each.first, each.count));
    }
    snapshot_->has_impulses = true;
    snapshot_->velocity_after.resize(6 * moving_);
    for (const std::unique_ptr<btRigidBody>& body : bodies_) {
      if (body->getUserIndex2() == kWorld) continue;
      const Eigen::Index at = 6 * body->getUserIndex2();
      snapshot_->velocity_after.segment<3>(at) = vector(body->getLinearVelocity());
      snapshot_->velocity_after.segment<3>(at + 3) = vector(body->getAngularVelocity());
    }
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  World world_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<Held> held_;
  int moving_ = 0;
  std::vector<Eigen::Vector3d> angular_changes_;  ///< by the step's torques, of moving bodies
  std::vector<Touch> touches_;  ///< touches_[i] is of snapshot_->contacts[i]
  Snapshot* snapshot_ = nullptr;
  Eigen::VectorXd velocity_;  ///< of the solver in the loop
  const VelocitySolver* loop_ = nullptr;
};

}  // namespace

std::unique_ptr<Engine> make_engine(const Scene& scene, const std::string& model) {
  require_built_scene(scene, model, "Bullet");
  return std::make_unique<BulletEngine>(scene);
}

}  // namespace lcpbench::capture
