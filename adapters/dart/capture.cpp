#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <dart/collision/CollisionObject.hpp>
#include <dart/collision/dart/DARTCollide.hpp>
#include <dart/collision/dart/DARTCollisionDetector.hpp>
#include <dart/constraint/BallJointConstraint.hpp>
#include <dart/constraint/BoxedLcpConstraintSolver.hpp>
#include <dart/constraint/ConstrainedGroup.hpp>
#include <dart/constraint/ContactConstraint.hpp>
#include <dart/constraint/JointConstraint.hpp>
#include <dart/constraint/JointCoulombFrictionConstraint.hpp>
#include <dart/constraint/PgsBoxedLcpSolver.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/SimpleFrame.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/math/Geometry.hpp>
#include <dart/simulation/World.hpp>
#include <fmt/format.h>

#include "adapters/capture/close_parts.h"
#include "adapters/capture/engine.h"
#include "adapters/capture/problem.h"

namespace lcpbench::capture {
namespace {

using dart::constraint::ContactConstraint;
using dart::dynamics::BodyNode;
using Eigen::Isometry3d;
using Eigen::Vector3d;

Isometry3d frame(const Vector3d& position, const Eigen::Quaterniond& rotation) {
  Isometry3d result = Isometry3d::Identity();
  result.translation() = position;
  result.linear() = rotation.toRotationMatrix();
  return result;
}

/// DART asks of which objects a contact is; boxes that are not where the world has them are of none.
class NoObject final : public dart::collision::CollisionObject {
 public:
  explicit NoObject(dart::collision::CollisionDetector& detector) : CollisionObject(&detector, &frame_) {}

 private:
  void updateEngineData() override {}
  dart::dynamics::SimpleFrame frame_;
};

/// A BoxOverlap.
void overlap(const PlacedPart& a, const PlacedPart& b, std::vector<Touch>& touches) {
  const auto pose = [](const PlacedPart& part) {
    Isometry3d result = Isometry3d::Identity();
    result.translation() = part.centre;
    result.linear() = part.axes;
    return result;
  };
  static const auto detector = dart::collision::DARTCollisionDetector::create();
  static NoObject none(*detector);
  dart::collision::CollisionResult found;
  dart::collision::collideBoxBox(&none, &none, 2 * a.size, pose(a), 2 * b.size, pose(b), found);
  for (const dart::collision::Contact& contact : found.getContacts()) {
    if (dart::collision::Contact::isZeroNormal(contact.normal)) continue;
    touches.push_back({a.body, b.body, contact.point, contact.normal, -contact.penetrationDepth});
  }
}

/// DART's default solver, which keeps what it finds.
class KeepingSolver final : public dart::constraint::BoxedLcpConstraintSolver {
 public:
  /// Of constraints of the last step; a joint's have one for each that DART found active. Empty where it has none.
  Eigen::VectorXd impulses(const dart::constraint::ConstraintBase& constraint) const {
    const auto found = impulses_.find(&constraint);
    return found == impulses_.end() ? Eigen::VectorXd() : found->second;
  }
  double impulse_of_limit_or_motor(const dart::dynamics::Joint& joint) const {
    return impulse(mJointConstraints, joint, [](const dart::dynamics::Joint& each) {
      return each.areLimitsEnforced() || each.getActuatorType() == dart::dynamics::Joint::SERVO;
    });
  }
  double impulse_of_friction(const dart::dynamics::Joint& joint) const {
    return impulse(mJointCoulombFrictionConstraints, joint, [](const dart::dynamics::Joint& each) {
      return each.getNumDofs() > 0 && each.getCoulombFriction(0) != 0;
    });
  }
  void forget() { impulses_.clear(); }

 private:
  void solveConstrainedGroup(dart::constraint::ConstrainedGroup& group) override {
    BoxedLcpConstraintSolver::solveConstrainedGroup(group);
    for (std::size_t i = 0; i < group.getNumConstraints(); ++i) {
      const dart::constraint::ConstraintBase& constraint = *group.getConstraint(i);
      const auto size = static_cast<Eigen::Index>(constraint.getDimension());
      impulses_[&constraint] = mX.segment(mOffset(static_cast<Eigen::Index>(i)), size);
    }
  }

  /// DART's constraints do not tell their joints: there is one for each joint that has it, in order.
  double impulse(const auto& constraints, const dart::dynamics::Joint& joint, const auto& has_constraint) const {
    std::size_t place = 0;
    for (const dart::dynamics::SkeletonPtr& skeleton : mSkeletons) {
      for (std::size_t i = 0; i < skeleton->getNumJoints(); ++i) {
        const dart::dynamics::Joint& each = *skeleton->getJoint(i);
        if (each.isKinematic() || !has_constraint(each)) continue;
        if (&each == &joint) {
          const Eigen::VectorXd found = impulses(*constraints[place]);
          return found.size() == 0 ? 0 : found(0);
        }
        ++place;
      }
    }
    return 0;
  }

  std::map<const dart::constraint::ConstraintBase*, Eigen::VectorXd> impulses_;
};

class DartEngine final : public Engine {
 public:
  explicit DartEngine(const Scene& scene)
      : Engine(scene, "DART", LCPBENCH_ENGINE_VERSION), world_(dart::simulation::World::create()) {
    auto keeping = std::make_unique<KeepingSolver>();
    solver_ = keeping.get();
    world_->setConstraintSolver(std::move(keeping));
    world_->setGravity(Vector3d(0, 0, -kGravity));
    world_->setTimeStep(scene_.step);
    // DART's own detector; others may not be packaged.
    world_->getConstraintSolver()->setCollisionDetector(dart::collision::DARTCollisionDetector::create());
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) add(i);
    for (const Loop& loop : scene_.loops) add(loop);
    if (scene_.cfm >= 0) ContactConstraint::setConstraintForceMixing(scene_.cfm);
    if (scene_.erp >= 0) ContactConstraint::setErrorReductionParameter(scene_.erp);
    if (scene_.sweeps == 0) return;
    const auto sweeps = std::make_shared<dart::constraint::PgsBoxedLcpSolver>();
    sweeps->setOption({scene_.sweeps, 0, 1e-15});
    solver_->setBoxedLcpSolver(sweeps);
    solver_->setSecondaryBoxedLcpSolver(nullptr);
  }

  void step(long index, Snapshot& snapshot, const VelocitySolver& loop) override {
    snapshot = {};
    apply_forces(index);
    look_at_bodies(snapshot);
    std::vector<std::size_t> taken;  // contacts of DART that are contacts of the snapshot
    if (loop)
      look_at_close_parts(snapshot);
    else
      taken = look_at_contacts(snapshot);
    if (scene_.articulated()) look_at_joints(snapshot);
    if (!scene_.soft.empty()) soften(snapshot);
    if (loop) {
      const Eigen::VectorXd after = loop(snapshot);
      set_velocities(moving_velocity(after, snapshot, scene_.step));
      move_on();
      if (snapshot.correction.size() > 0) set_velocities(after);
      return;
    }
    solver_->forget();
    world_->step();
    keep_impulses(taken, snapshot);
    keep_velocities(snapshot);
  }

 private:
  void add(std::size_t index) {
    const Body& body = scene_.bodies[index];
    BodyNode* node = body.joint ? add_link(body) : add_root(index, body);
    for (const Part& part : body.parts) {
      dart::dynamics::ShapePtr shape;
      if (part.kind == Part::Kind::kSphere)
        shape = std::make_shared<dart::dynamics::SphereShape>(part.size.x());
      else
        shape = std::make_shared<dart::dynamics::BoxShape>(2 * part.size);
      dart::dynamics::ShapeNode* shape_node =
          node->createShapeNodeWith<dart::dynamics::CollisionAspect, dart::dynamics::DynamicsAspect>(shape);
      shape_node->setRelativeTranslation(part.offset);
      shape_node->getDynamicsAspect()->setFrictionCoeff(scene_.mu);
      shape_node->getDynamicsAspect()->setRestitutionCoeff(std::sqrt(scene_.restitution));  // DART multiplies two
    }
    if (body.mass > 0) {
      node->setMass(body.mass);
      node->setMomentOfInertia(body.inertia.x(), body.inertia.y(), body.inertia.z());
    }
    index_of_[node] = index;
    nodes_.push_back(node);
  }

  /// A free body or a part of the world. Links of a robot join its skeleton later.
  BodyNode* add_root(std::size_t index, const Body& body) {
    const dart::dynamics::SkeletonPtr skeleton =
        dart::dynamics::Skeleton::create(fmt::format("s{}", index));
    const Isometry3d pose = frame(body.position, body.orientation);
    BodyNode* node = nullptr;
    if (body.mass > 0) {
      auto [joint, created] = skeleton->createJointAndBodyNodePair<dart::dynamics::FreeJoint>();
      joint->setTransform(pose);
      joint->setLinearVelocity(body.linear_velocity);
      joint->setAngularVelocity(body.angular_velocity);
      node = created;
      moving_of_.emplace(node, static_cast<int>(moving_of_.size()));
    } else {
      auto [joint, created] = skeleton->createJointAndBodyNodePair<dart::dynamics::WeldJoint>();
      joint->setTransformFromParentBodyNode(pose);
      node = created;
    }
    skeletons_.push_back(skeleton);
    world_->addSkeleton(skeleton);
    return node;
  }

  BodyNode* add_link(const Body& body) {
    const Joint& of = *body.joint;
    const auto parent = static_cast<std::size_t>(of.parent);
    const Body& above = scene_.bodies[parent];
    const Isometry3d anchor = frame(of.anchor, Eigen::Quaterniond::Identity());
    const dart::dynamics::SkeletonPtr skeleton = nodes_[parent]->getSkeleton();
    // Out of the world while it changes, so that the world counts its new coordinates.
    world_->removeSkeleton(skeleton);
    dart::dynamics::GenericJoint<dart::math::R1Space>* joint = nullptr;
    BodyNode* node = nullptr;
    const auto join = [&]<class Kind>(Kind*) {
      typename Kind::Properties names;
      names.mName = fmt::format("j{}", nodes_.size());
      const auto [made, created] = skeleton->createJointAndBodyNodePair<Kind>(
          nodes_[parent], names, BodyNode::AspectProperties(fmt::format("b{}", nodes_.size())));
      made->setAxis(of.axis);
      joint = made;
      node = created;
    };
    if (of.slides) {
      join(static_cast<dart::dynamics::PrismaticJoint*>(nullptr));
    } else {
      join(static_cast<dart::dynamics::RevoluteJoint*>(nullptr));
    }
    joint->setTransformFromParentBodyNode(frame(above.position, above.orientation).inverse() * anchor);
    joint->setTransformFromChildBodyNode(frame(body.position, body.orientation).inverse() * anchor);
    joint->setPositionLowerLimit(0, of.lower);
    joint->setPositionUpperLimit(0, of.upper);
    joint->setLimitEnforcement(true);
    if (of.speed != 0) {
      joint->setActuatorType(dart::dynamics::Joint::SERVO);
      joint->setForceLowerLimit(0, -of.effort);
      joint->setForceUpperLimit(0, of.effort);
    } else {
      joint->setCoulombFriction(0, of.effort);
    }
    world_->addSkeleton(skeleton);
    return node;
  }

  /// A loop of the scene, and where its point is in the frames of both bodies.
  struct Held {
    dart::constraint::ConstraintBasePtr constraint;
    const BodyNode* first;
    const BodyNode* second;
    Vector3d in_first, in_second;
  };

  void add(const Loop& loop) {
    BodyNode* first = nodes_[static_cast<std::size_t>(loop.first)];
    BodyNode* second = nodes_[static_cast<std::size_t>(loop.second)];
    const auto constraint = std::make_shared<dart::constraint::BallJointConstraint>(first, second, loop.anchor);
    solver_->addConstraint(constraint);
    held_.push_back({constraint, first, second, first->getWorldTransform().inverse() * loop.anchor,
                     second->getWorldTransform().inverse() * loop.anchor});
  }

  void apply_forces(long index) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const Body& body = scene_.bodies[i];
      const Vector3d push = force_on(body, index) + Vector3d(0, 0, kGravity * body.mass);
      if (body.mass > 0 && !push.isZero(0)) nodes_[i]->addExtForce(push, Vector3d::Zero(), false, true);
      if (!body.joint) continue;
      dart::dynamics::Joint& joint = *nodes_[i]->getParentJoint();
      if (body.joint->speed != 0) {
        joint.setCommand(0, body.joint->speed);
        continue;
      }
      joint.setForce(0, controller_torque(*body.joint, joint.getPosition(0), joint.getVelocity(0),
                                          static_cast<double>(index) * scene_.step));
    }
  }

  void look_at_bodies(Snapshot& snapshot) {
    std::vector<Pose> poses;
    for (const BodyNode* node : nodes_) {
      const Isometry3d pose = node->getWorldTransform();
      poses.push_back({pose.translation(), Eigen::Quaterniond(pose.linear())});
    }
    snapshot.poses = part_poses(scene_, poses);
    int first = 0;
    first_.clear();
    for (const dart::dynamics::SkeletonPtr& skeleton : skeletons_) {
      const auto size = static_cast<int>(skeleton->getNumDofs());
      first_[skeleton.get()] = first;
      first += size;
      if (size == 0) continue;
      // DART's own step of the velocities, whose coordinates turn with a free body; undone, because the step does it.
      const Eigen::VectorXd before = skeleton->getVelocities();
      const BodyNode& root = *skeleton->getBodyNode(0);
      const Vector3d linear = root.getLinearVelocity();
      const Vector3d angular = root.getAngularVelocity();
      skeleton->computeForwardDynamics();
      skeleton->integrateVelocities(scene_.step);
      if (scene_.articulated())
        snapshot.blocks.push_back({skeleton->getMassMatrix(), skeleton->getVelocities()});
      else
        snapshot.bodies.push_back(free_body(root, linear, angular));
      skeleton->setVelocities(before);
    }
    coordinates_ = first;
    velocity_.resize(first);
    Eigen::Index at = 0;
    for (const BlockState& block : snapshot.blocks) {
      velocity_.segment(at, block.velocity.size()) = block.velocity;
      at += block.velocity.size();
    }
  }

  /// @param linear, angular  velocities before the forces of the step
  BodyState free_body(const BodyNode& node, const Vector3d& linear, const Vector3d& angular) const {
    const Body& body = scene_.bodies[index_of_.at(&node)];
    const Isometry3d pose = node.getWorldTransform();
    BodyState state;
    state.mass = body.mass;
    state.inertia = world_inertia(pose.linear(), body.inertia);
    state.position = pose.translation();
    state.linear_velocity = node.getLinearVelocity();
    state.angular_velocity = node.getAngularVelocity();
    state.linear_change = state.linear_velocity - linear;
    state.angular_change = state.angular_velocity - angular;
    return state;
  }

  static const BodyNode* node_of(const dart::collision::CollisionObject* object) {
    return object->getShapeFrame()->asShapeNode()->getBodyNodePtr().get();
  }

  /// Of DART's step. @returns which of its contacts are contacts of the snapshot
  std::vector<std::size_t> look_at_contacts(Snapshot& snapshot) {
    collision_.clear();
    dart::constraint::ConstraintSolver& solver = *world_->getConstraintSolver();
    solver.getCollisionGroup()->collide(solver.getCollisionOption(), &collision_);
    std::vector<std::size_t> taken;
    for (std::size_t i = 0; i < collision_.getNumContacts(); ++i) {
      const dart::collision::Contact& found = collision_.getContact(i);
      if (dart::collision::Contact::isZeroNormal(found.normal)) continue;
      const std::size_t a = index_of_.at(node_of(found.collisionObject1));
      const std::size_t b = index_of_.at(node_of(found.collisionObject2));
      if (look_at({a, b, found.point, found.normal, -found.penetrationDepth}, snapshot)) taken.push_back(i);
    }
    return taken;
  }

  /// As DART without the collisions of a skeleton with itself.
  void look_at_close_parts(Snapshot& snapshot) {
    for (const Touch& touch : close_parts(scene_, snapshot.poses, overlap)) {
      const BodyNode& a = *nodes_[touch.body_a];
      const BodyNode& b = *nodes_[touch.body_b];
      const double approach = touch.normal.dot(velocity(a, touch.point) - velocity(b, touch.point));
      if (a.getSkeleton() == b.getSkeleton() || waits_to_bounce(scene_, touch.gap, approach)) continue;
      look_at(touch, snapshot);
    }
  }

  /// False: not a contact of a body that moves.
  bool look_at(const Touch& found, Snapshot& snapshot) {
    const BodyNode* a = nodes_[found.body_a];
    const BodyNode* b = nodes_[found.body_b];
    const bool a_moves = a->getNumDependentGenCoords() > 0;
    if (!a_moves && b->getNumDependentGenCoords() == 0) return false;
    const Vector3d approach = velocity(*a, found.point) - velocity(*b, found.point);
    ContactState contact = touch(scene_, found.body_a, found.body_b, found.point, found.normal, found.gap, approach);
    const BodyNode* frame_node = a_moves ? a : b;
    contact.local = frame_node->getWorldTransform().inverse() * contact.point;
    if (!scene_.soft.empty()) {
      Vector3d first = contact.normal.cross(Vector3d::UnitZ());
      if (first.squaredNorm() < 1e-12) first = contact.normal.cross(Vector3d::UnitX());
      set_square_friction(first.normalized(), contact);
    }
    if (scene_.articulated()) {
      contact.rows = rows(*a, *b, contact);
    } else {
      contact.body_a = moving(a);
      contact.body_b = moving(b);
    }
    snapshot.contacts.push_back(std::move(contact));
    return true;
  }

  int moving(const BodyNode* node) const {
    const auto found = moving_of_.find(node);
    return found == moving_of_.end() ? kWorld : found->second;
  }

  static Vector3d velocity(const BodyNode& node, const Vector3d& point) {
    return node.getLinearVelocity(node.getWorldTransform().inverse() * point);
  }

  /// Of the velocity of a point of body a, as a point of body b sees it, over the coordinates of all blocks.
  Eigen::MatrixXd jacobian(const BodyNode& a, const BodyNode& b, const Vector3d& point) const {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, coordinates_);
    for (const BodyNode* node : {&a, &b}) {
      const dart::dynamics::ConstSkeletonPtr skeleton = node->getSkeleton();
      if (skeleton->getNumDofs() == 0) continue;
      const Vector3d local = node->getWorldTransform().inverse() * point;
      const Eigen::MatrixXd part = skeleton->getLinearJacobian(node, local);
      J.middleCols(first_.at(skeleton.get()), part.cols()) += node == &a ? part : -part;
    }
    return J;
  }

  std::vector<int> used_coordinates(const Eigen::MatrixXd& J) const {
    std::vector<int> used;
    for (int k = 0; k < coordinates_; ++k) {
      if (!J.col(k).isZero(0)) used.push_back(k);
    }
    return used;
  }

  Rows rows(const BodyNode& a, const BodyNode& b, const ContactState& contact) const {
    const Eigen::MatrixXd J = jacobian(a, b, contact.point);
    Rows result;
    result.coordinates = used_coordinates(J);
    const Eigen::MatrixXd dense = J(Eigen::all, result.coordinates);
    result.normal = dense.transpose() * contact.normal;
    result.tangent = dense.transpose() * contact.tangent;
    result.second_tangent = dense.transpose() * contact.normal.cross(contact.tangent);
    return result;
  }

  void look_at_joints(Snapshot& snapshot) {
    of_rows_.clear();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (scene_.bodies[i].joint) look_at_joint(i, snapshot);
    }
    for (std::size_t k = 0; k < held_.size(); ++k) look_at_loop(held_[k], k, snapshot);
    const auto note = [&](const char* what, long& count) {
      if (count > 0) snapshot.notes.push_back(fmt::format("{}: {}", what, count));
      count = 0;
    };
    note("motors at a limit, which DART leaves out", motors_left_out_);
    note("dry friction of joints at rest, which DART leaves out", friction_left_out_);
    note("rows of loops that nothing moves, left out", rows_left_out_);
  }

  /// Limits as DART has them: of joints that have reached them, or would in this step. A joint at a limit has no motor,
  /// and one at rest no dry friction: hard problems have both. [DART, JointConstraint.cpp]
  void look_at_joint(std::size_t body, Snapshot& snapshot) {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    const Joint& of = *scene_.bodies[body].joint;
    const dart::dynamics::Joint& joint = *nodes_[body]->getParentJoint();
    const int coordinate = first_.at(joint.getSkeleton().get()) + static_cast<int>(joint.getIndexInSkeleton(0));
    const double speed = velocity_(coordinate), h = scene_.step;
    const double above_lower = joint.getPosition(0) - of.lower, above_upper = joint.getPosition(0) - of.upper;
    RowState row{.coordinates = {coordinate}, .direction = Eigen::VectorXd::Ones(1), .is_angle = !of.slides};
    const auto limit_or_motor = [&joint](const KeepingSolver& solver) {
      return solver.impulse_of_limit_or_motor(joint);
    };
    const bool at_lower = above_lower < 0 || (above_upper <= 0 && speed < -above_lower / h);
    const bool at_upper = !at_lower && (above_upper > 0 || speed > -above_upper / h);
    if (at_lower || at_upper) {
      row.lower = at_upper ? -kNone : 0;
      row.upper = at_lower ? kNone : 0;
      row.offset = (at_lower ? std::max(above_lower, 0.0) : std::min(above_upper, 0.0)) / h;
      row.name = fmt::format("{} limit j{}", of.kind(), body);
      keep(row, limit_or_motor, snapshot);
    }
    if (of.effort == 0) return;
    row.upper = h * of.effort;
    row.lower = -row.upper;
    row.offset = -of.speed;
    if (of.speed == 0) {
      row.name = fmt::format("{} friction j{}", of.kind(), body);
      if (speed == 0) ++friction_left_out_;
      if (speed == 0 && !scene_.soft.empty()) return;
      return keep(row, [&joint](const KeepingSolver& solver) { return solver.impulse_of_friction(joint); }, snapshot);
    }
    row.name = fmt::format("{} motor j{}", of.kind(), body);
    if (!at_lower && !at_upper) {
      if (!scene_.soft.empty()) row.offset = -std::clamp(of.speed, -above_lower / h, -above_upper / h);
      return keep(row, limit_or_motor, snapshot);
    }
    ++motors_left_out_;
    if (scene_.soft.empty()) keep(row, [](const KeepingSolver&) { return 0.0; }, snapshot);
  }

  /// In the axes of the first body, as DART. Of a chain in a plane, the row out of it moves nothing.
  void look_at_loop(const Held& held, std::size_t number, Snapshot& snapshot) {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    const Isometry3d frame = held.first->getWorldTransform();
    const Vector3d point = frame * held.in_first;
    const Eigen::MatrixXd J = frame.linear().transpose() * jacobian(*held.first, *held.second, point);
    const Vector3d apart = frame.linear().transpose() * (point - held.second->getWorldTransform() * held.in_second);
    const double rate = dart::constraint::DynamicJointConstraint::getErrorReductionParameter() / scene_.step;
    for (int k = 0; k < 3; ++k) {
      if (!(J.row(k).norm() > 1e-9 * J.norm())) {
        ++rows_left_out_;
        continue;
      }
      RowState row;
      row.coordinates = used_coordinates(J);
      row.direction = J(k, row.coordinates);
      row.lower = -kNone;
      row.upper = kNone;
      row.name = numbered(fmt::format("connect equality {}", number), k + 1);
      if (!scene_.soft.empty()) row.offset = rate * apart(k);
      const auto& constraint = held.constraint;
      keep(row, [&constraint, k](const KeepingSolver& solver) {
        const Eigen::VectorXd found = solver.impulses(*constraint);
        return found.size() == 0 ? 0 : found(k);
      }, snapshot);
    }
  }

  /// @param impulse  after DART's step
  void keep(RowState row, std::function<double(const KeepingSolver&)> impulse, Snapshot& snapshot) {
    snapshot.rows.push_back(std::move(row));
    of_rows_.push_back(std::move(impulse));
  }

  /// Gives the contacts the rows of DART [ContactConstraint.cpp]. Its diagonal is (1 + cfm) M_ii. Contacts part at erp
  /// penetration / step, at most a constant, or at the speed of the bounce if that is larger and above 0.1 m/s.
  /// Friction is limited along each of two directions by itself. DART has a tangential compliance for each of the two,
  /// a contact of the problem has one, their mean. Bounded rows have cfm alike.
  void soften(Snapshot& snapshot) const {
    for (ContactState& contact : snapshot.contacts) contact.offset = 0;
    const Problem hard = problem_of(snapshot);
    const Lcp& lcp = hard.lcp();
    const double cfm = ContactConstraint::getConstraintForceMixing();
    auto row = static_cast<Eigen::Index>(snapshot.contacts.size());
    for (Eigen::Index i = 0; ContactState & contact : snapshot.contacts) {
      const double correction = ContactConstraint::getErrorReductionParameter() * -contact.gap / scene_.step;
      const double rebound = scene_.restitution * -lcp.q(i);
      const double outwards = std::min(correction, ContactConstraint::getMaxErrorReductionVelocity());
      contact.offset = -(rebound > 0.1 ? std::max(outwards, rebound) : outwards);
      contact.compliance_n = cfm * lcp.M(i, i);
      contact.compliance_t = cfm / 2 * (lcp.M(row, row) + lcp.M(row + 1, row + 1));
      ++i;
      row += contact.edges;
    }
    row = lcp.M.rows() - static_cast<Eigen::Index>(snapshot.rows.size());
    for (RowState& each : snapshot.rows) {
      each.compliance = dart::constraint::JointConstraint::getConstraintForceMixing() * lcp.M(row, row);
      ++row;
    }
  }

  /// With move_on() what world_->step() does after its solver.
  void set_velocities(const Eigen::VectorXd& velocity) {
    for (const dart::dynamics::SkeletonPtr& skeleton : skeletons_) {
      const auto size = static_cast<Eigen::Index>(skeleton->getNumDofs());
      if (size == 0) continue;
      const Eigen::VectorXd part = velocity.segment(first_.at(skeleton.get()), size);
      if (scene_.articulated()) {
        skeleton->setVelocities(part);
      } else {
        auto& joint = static_cast<dart::dynamics::FreeJoint&>(*skeleton->getJoint(0));
        joint.setLinearVelocity(part.head<3>());
        joint.setAngularVelocity(part.tail<3>());
      }
    }
  }

  void move_on() {
    for (const dart::dynamics::SkeletonPtr& skeleton : skeletons_) {
      if (skeleton->getNumDofs() == 0) continue;
      skeleton->integratePositions(scene_.step);
      skeleton->clearInternalForces();
      skeleton->clearExternalForces();
      skeleton->resetCommands();
    }
  }

  void keep_impulses(const std::vector<std::size_t>& taken, Snapshot& snapshot) const {
    const auto& solved = world_->getConstraintSolver()->getLastCollisionResult();
    snapshot.has_impulses = solved.getNumContacts() == collision_.getNumContacts();
    if (!snapshot.has_impulses) return;
    for (std::size_t k = 0; k < taken.size(); ++k) {
      ContactState& contact = snapshot.contacts[k];
      contact.impulse = in_axes_of(contact, scene_.step * solved.getContact(taken[k]).force);
    }
    for (std::size_t k = 0; k < of_rows_.size(); ++k) snapshot.rows[k].impulse = of_rows_[k](*solver_);
  }

  /// Of robots in the coordinates of before: DART's step turns the linear velocity of a free root with the root.
  void keep_velocities(Snapshot& snapshot) const {
    snapshot.velocity_after.resize(coordinates_);
    Eigen::Index at = 0;
    for (const dart::dynamics::SkeletonPtr& skeleton : skeletons_) {
      const auto size = static_cast<Eigen::Index>(skeleton->getNumDofs());
      if (size == 0) continue;
      if (scene_.articulated()) {
        Eigen::VectorXd after = skeleton->getVelocities();
        if (skeleton->getRootJoint()->getNumDofs() == 6) {
          after.segment<3>(3) = dart::math::expMapRot(scene_.step * after.head<3>()) * after.segment<3>(3);
        }
        snapshot.velocity_after.segment(at, size) = after;
        at += size;
        continue;
      }
      snapshot.velocity_after.segment<3>(at) = skeleton->getBodyNode(0)->getLinearVelocity();
      snapshot.velocity_after.segment<3>(at + 3) = skeleton->getBodyNode(0)->getAngularVelocity();
      at += 6;
    }
  }

  dart::simulation::WorldPtr world_;
  std::vector<dart::dynamics::SkeletonPtr> skeletons_;
  std::vector<BodyNode*> nodes_;  ///< of the scene's bodies
  std::map<const BodyNode*, std::size_t> index_of_;
  std::map<const BodyNode*, int> moving_of_;  ///< of a free body: its index in the snapshot
  std::map<const void*, int> first_;          ///< of a skeleton: its first coordinate
  int coordinates_ = 0;
  Eigen::VectorXd velocity_;  ///< of robots, with the step's forces
  std::vector<Held> held_;
  KeepingSolver* solver_ = nullptr;
  std::vector<std::function<double(const KeepingSolver&)>> of_rows_;  ///< the impulses of the snapshot's rows
  long motors_left_out_ = 0, friction_left_out_ = 0, rows_left_out_ = 0;
  dart::collision::CollisionResult collision_;
};

}  // namespace

std::unique_ptr<Engine> make_engine(const Scene& scene, const std::string& model) {
  require_built_scene(scene, model, "DART");
  return std::make_unique<DartEngine>(scene);
}

}  // namespace lcpbench::capture
