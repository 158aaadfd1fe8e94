#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <dart/collision/CollisionObject.hpp>
#include <dart/collision/dart/DARTCollide.hpp>
#include <dart/collision/dart/DARTCollisionDetector.hpp>
#include <dart/constraint/BoxedLcpConstraintSolver.hpp>
#include <dart/constraint/ContactConstraint.hpp>
#include <dart/constraint/PgsBoxedLcpSolver.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/SimpleFrame.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/simulation/World.hpp>
#include <fmt/format.h>

#include "adapters/capture/close_parts.h"
#include "adapters/capture/engine.h"
#include "adapters/capture/problem.h"
#include "core/error.h"

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

class DartEngine final : public Engine {
 public:
  explicit DartEngine(const Scene& scene)
      : Engine(scene, "DART", LCPBENCH_ENGINE_VERSION), world_(dart::simulation::World::create()) {
    world_->setGravity(Vector3d(0, 0, -kGravity));
    world_->setTimeStep(scene_.step);
    // DART's own detector; others may not be packaged.
    world_->getConstraintSolver()->setCollisionDetector(dart::collision::DARTCollisionDetector::create());
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) add(i);
    if (scene_.cfm >= 0) ContactConstraint::setConstraintForceMixing(scene_.cfm);
    if (scene_.erp >= 0) ContactConstraint::setErrorReductionParameter(scene_.erp);
    if (scene_.sweeps == 0) return;
    const auto sweeps = std::make_shared<dart::constraint::PgsBoxedLcpSolver>();
    sweeps->setOption({scene_.sweeps, 0, 1e-15});
    auto& solver = dynamic_cast<dart::constraint::BoxedLcpConstraintSolver&>(*world_->getConstraintSolver());
    solver.setBoxedLcpSolver(sweeps);
    solver.setSecondaryBoxedLcpSolver(nullptr);
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
    if (scene_.articulated()) look_at_limits(snapshot);
    if (!scene_.soft.empty()) soften(snapshot);
    if (loop) {
      const Eigen::VectorXd after = loop(snapshot);
      set_velocities(moving_velocity(after, snapshot, scene_.step));
      move_on();
      if (snapshot.correction.size() > 0) set_velocities(after);
      return;
    }
    world_->step();
    keep_impulses(taken, snapshot);
    keep_velocities(snapshot);
  }

 private:
  void add(std::size_t index) {
    const Body& body = scene_.bodies[index];
    BodyNode* node = body.hinge ? add_link(body) : add_root(index, body);
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
    const Hinge& hinge = *body.hinge;
    const auto parent = static_cast<std::size_t>(hinge.parent);
    const Body& above = scene_.bodies[parent];
    const Isometry3d anchor = frame(hinge.anchor, Eigen::Quaterniond::Identity());
    const dart::dynamics::SkeletonPtr skeleton = nodes_[parent]->getSkeleton();
    // Out of the world while it changes, so that the world counts its new coordinates.
    world_->removeSkeleton(skeleton);
    dart::dynamics::RevoluteJoint::Properties names;
    names.mName = fmt::format("j{}", nodes_.size());
    auto [joint, node] = skeleton->createJointAndBodyNodePair<dart::dynamics::RevoluteJoint>(
        nodes_[parent], names, BodyNode::AspectProperties(fmt::format("b{}", nodes_.size())));
    joint->setTransformFromParentBodyNode(frame(above.position, above.orientation).inverse() * anchor);
    joint->setTransformFromChildBodyNode(frame(body.position, body.orientation).inverse() * anchor);
    joint->setAxis(hinge.axis);
    joint->setPositionLowerLimit(0, hinge.lower);
    joint->setPositionUpperLimit(0, hinge.upper);
    joint->setLimitEnforcement(true);
    world_->addSkeleton(skeleton);
    return node;
  }

  void apply_forces(long index) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const Body& body = scene_.bodies[i];
      const Vector3d push = force_on(body, index) + Vector3d(0, 0, kGravity * body.mass);
      if (body.mass > 0 && !push.isZero(0)) nodes_[i]->addExtForce(push, Vector3d::Zero(), false, true);
      if (!body.hinge) continue;
      dart::dynamics::Joint& joint = *nodes_[i]->getParentJoint();
      joint.setForce(0, controller_torque(*body.hinge, joint.getPosition(0), joint.getVelocity(0),
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

  Rows rows(const BodyNode& a, const BodyNode& b, const ContactState& contact) const {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, coordinates_);
    for (const BodyNode* node : {&a, &b}) {
      const dart::dynamics::ConstSkeletonPtr skeleton = node->getSkeleton();
      if (skeleton->getNumDofs() == 0) continue;
      const Vector3d local = node->getWorldTransform().inverse() * contact.point;
      const Eigen::MatrixXd part = skeleton->getLinearJacobian(node, local);
      J.middleCols(first_.at(skeleton.get()), part.cols()) += node == &a ? part : -part;
    }
    Rows result;
    std::vector<int>& used = result.coordinates;
    for (int k = 0; k < coordinates_; ++k) {
      if (!J.col(k).isZero(0)) used.push_back(k);
    }
    const Eigen::MatrixXd dense = J(Eigen::all, used);
    result.normal = dense.transpose() * contact.normal;
    result.tangent = dense.transpose() * contact.tangent;
    result.second_tangent = dense.transpose() * contact.normal.cross(contact.tangent);
    return result;
  }

  /// Joints at their limits, as DART has them: those that have reached it.
  void look_at_limits(Snapshot& snapshot) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (!scene_.bodies[i].hinge) continue;
      const dart::dynamics::Joint& joint = *nodes_[i]->getParentJoint();
      const int coordinate = first_.at(joint.getSkeleton().get()) + static_cast<int>(joint.getIndexInSkeleton(0));
      for (const double sign : {1.0, -1.0}) {
        const double limit = sign > 0 ? joint.getPositionLowerLimit(0) : joint.getPositionUpperLimit(0);
        ContactState row;
        row.gap = sign * (joint.getPosition(0) - limit);
        if (row.gap > 0) continue;
        row.edges = 0;
        row.pair = fmt::format("{}-{}", sign > 0 ? "lower" : "upper", i);
        row.rows.emplace();
        row.rows->coordinates = {coordinate};
        row.rows->normal = Eigen::VectorXd::Constant(1, sign);
        snapshot.contacts.push_back(std::move(row));
      }
    }
  }

  /// Gives the contacts the rows of DART [ContactConstraint.cpp]. Its diagonal is (1 + cfm) M_ii. Contacts part at erp
  /// penetration / step, at most a constant, or at the speed of the bounce if that is larger and above 0.1 m/s.
  /// Friction is limited along each of two directions by itself. DART has a tangential compliance for each of the two,
  /// a contact of the problem has one, their mean. @pre every contact has 4 edges: no joint limits
  void soften(Snapshot& snapshot) const {
    for (ContactState& contact : snapshot.contacts) {
      Vector3d first = contact.normal.cross(Vector3d::UnitZ());
      if (first.squaredNorm() < 1e-12) first = contact.normal.cross(Vector3d::UnitX());
      set_square_friction(first.normalized(), contact);
      contact.offset = 0;
    }
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

  /// DART's own, of contacts; it does not tell those of limits, so that scenes with joints have none.
  void keep_impulses(const std::vector<std::size_t>& taken, Snapshot& snapshot) const {
    const auto& solved = world_->getConstraintSolver()->getLastCollisionResult();
    snapshot.has_impulses = !scene_.articulated() && solved.getNumContacts() == collision_.getNumContacts();
    if (!snapshot.has_impulses) return;
    for (std::size_t k = 0; k < taken.size(); ++k) {
      ContactState& contact = snapshot.contacts[k];
      contact.impulse = in_axes_of(contact, scene_.step * solved.getContact(taken[k]).force);
    }
  }

  /// Not of robots: the coordinates of a free root have turned with it.
  void keep_velocities(Snapshot& snapshot) const {
    if (scene_.articulated()) return;
    snapshot.velocity_after.resize(coordinates_);
    Eigen::Index at = 0;
    for (const dart::dynamics::SkeletonPtr& skeleton : skeletons_) {
      if (skeleton->getNumDofs() == 0) continue;
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
  dart::collision::CollisionResult collision_;
};

}  // namespace

std::unique_ptr<Engine> make_engine(const Scene& scene, const std::string& model) {
  if (!model.empty()) throw InputError("--model: lcpbench reads no model files with DART, but with MuJoCo");
  if (!scene.model.empty()) throw InputError("scene '" + scene.name + "' is a model of MuJoCo's and runs there only");
  if (!scene.loops.empty()) {
    throw InputError("scene '" + scene.name + "' has a closed chain, which is captured from MuJoCo, not from DART");
  }
  if (!scene.soft.empty() && scene.articulated()) {
    throw InputError("--soft: DART does not tell the impulses of robots, which would be judged; scene '" + scene.name +
                     "' has joints");
  }
  return std::make_unique<DartEngine>(scene);
}

}  // namespace lcpbench::capture
