#include "native/steppers/world.h"

#include <Eigen/LU>
#include <cmath>
#include <numeric>
#include <tuple>

namespace lcpbench::steppers {
namespace {

void turn(MovingBody& body, const Vector3d& rotation) {
  const double angle = rotation.norm();
  if (angle == 0) return;
  body.turn = (Eigen::Quaterniond(Eigen::AngleAxisd(angle, rotation / angle)) * body.turn).normalized();
  body.rotation = body.turn.toRotationMatrix();
}

Vector3d rotation_vector(Eigen::Quaterniond turn) {
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  if (sine == 0) return Vector3d::Zero();
  return 2 * std::atan2(sine, turn.w()) / sine * turn.vec();
}

/// Columns: the arm times each row of the frame.
Matrix3d levers(const Vector3d& arm, const Matrix3d& frame) {
  Matrix3d result;
  for (int k = 0; k < 3; ++k) result.col(k) = arm.cross(Vector3d(frame.row(k)));
  return result;
}

/// Of [a b; b c].
double larger_eigenvalue(double a, double b, double c) {
  return (a + c + std::sqrt((a - c) * (a - c) + 4 * b * b)) / 2;
}

}  // namespace

[[gnu::flatten]] void World::load(const StepProblem& step) {
  const RigidScene& scene = std::get<RigidScene>(step.contacts);
  moves = 0;
  bodies.assign(scene.bodies.size() + 1, {});
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const RigidBody& from = scene.bodies[i];
    MovingBody& body = bodies[i];
    body.inverse_mass = 1 / from.mass;
    body.inverse_inertia = from.inertia.inverse();
    body.force_v = step.force_change.segment<3>(static_cast<Index>(6 * i));
    body.force_w = step.force_change.segment<3>(static_cast<Index>(6 * i) + 3);
    body.v = from.linear_velocity - body.force_v;
    body.w = from.angular_velocity - body.force_w;
  }
  set_order(scene);
  for (StepContact& contact : contacts) {
    const RigidContact& from = scene.contacts[contact.number];
    const bool on_world = from.body_b == RigidContact::kWorld;
    contact.frame << from.normal.transpose(), from.tangent.transpose(), from.normal.cross(from.tangent).transpose();
    contact.arm_a = contact.start_a = from.point - scene.bodies[contact.a].position;
    if (on_world)
      contact.start_b.setZero();
    else
      contact.start_b = from.point - scene.bodies[contact.b].position;
    contact.arm_b = contact.start_b;
    contact.gap = contact.start_gap = step.gaps[contact.number];
    contact.impulse.setZero();
    contact.mu = from.edges > 0 ? from.mu : 0;
    contact.bounce = contact.gap > 0 ? 0 : -from.b;
    set_levers(contact);
    Matrix3d inverse = contact.lever_a.transpose() * contact.turn_a + contact.lever_b.transpose() * contact.turn_b;
    inverse.diagonal().array() += bodies[contact.a].inverse_mass + bodies[contact.b].inverse_mass;
    contact.normal_mass = 1 / inverse(0, 0);
    contact.tangent_mass = 1 / larger_eigenvalue(inverse(1, 1), inverse(2, 1), inverse(2, 2));
  }
}

/// A contact's turn is the first after those of its bodies' earlier contacts.
void World::set_order(const RigidScene& scene) {
  contacts.resize(scene.contacts.size());
  turns_.clear();
  next_turn_.assign(bodies.size(), 0);
  begins_.assign(1, 0);
  const auto bodies_of = [&](const RigidContact& contact) {
    return std::pair(static_cast<std::size_t>(contact.body_a), contact.body_b == RigidContact::kWorld
                                                                   ? bodies.size() - 1
                                                                   : static_cast<std::size_t>(contact.body_b));
  };
  for (const RigidContact& contact : scene.contacts) {
    const auto [a, b] = bodies_of(contact);
    const std::size_t turn = std::max(next_turn_[a], next_turn_[b]);
    next_turn_[a] = turn + 1;
    if (b + 1 < bodies.size()) next_turn_[b] = turn + 1;
    turns_.push_back(turn);
    begins_.resize(std::max(begins_.size(), turn + 2), 0);
    ++begins_[turn + 1];
  }
  std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
  for (std::size_t i = 0; i < turns_.size(); ++i) {
    StepContact& contact = contacts[begins_[turns_[i]]++];
    contact.number = i;
    std::tie(contact.a, contact.b) = bodies_of(scene.contacts[i]);
  }
}

void World::push(double share) {
  for (MovingBody& body : bodies) {
    body.v += share * body.force_v;
    body.w += share * body.force_w;
  }
}

void World::move(double dt) {
  ++moves;
  for (MovingBody& body : bodies) {
    body.shift += dt * body.v;
    turn(body, dt * body.w);
  }
  update_contacts();
}

void World::update(StepContact& contact) const {
  contact.arm_a = bodies[contact.a].rotation * contact.start_a;
  contact.arm_b = bodies[contact.b].rotation * contact.start_b;
  contact.gap = contact.start_gap + contact.frame.row(0).dot(apart(contact));
}

void World::set_levers(StepContact& contact) const {
  contact.lever_a = levers(contact.arm_a, contact.frame);
  contact.lever_b = levers(contact.arm_b, contact.frame);
  contact.turn_a = bodies[contact.a].inverse_inertia * contact.lever_a;
  contact.turn_b = bodies[contact.b].inverse_inertia * contact.lever_b;
  contact.normal_to_tangents = contact.lever_a.rightCols<2>().transpose() * contact.turn_a.col(0) +
                               contact.lever_b.rightCols<2>().transpose() * contact.turn_b.col(0);
}

[[gnu::flatten]] void World::update_contacts() {
  for (StepContact& contact : contacts) {
    update(contact);
    set_levers(contact);
  }
}

Vector3d World::apart(const StepContact& contact) const {
  const Vector3d a = bodies[contact.a].shift + contact.arm_a - contact.start_a;
  return a - (bodies[contact.b].shift + contact.arm_b - contact.start_b);
}

Vector3d World::relative_velocity(const StepContact& contact) const {
  const MovingBody& a = bodies[contact.a];
  const MovingBody& b = bodies[contact.b];
  return contact.frame * (a.v + a.w.cross(contact.arm_a) - b.v - b.w.cross(contact.arm_b));
}

void World::apply(const StepContact& contact, const Vector3d& impulse) {
  const Vector3d p = contact.frame.transpose() * impulse;
  MovingBody& a = bodies[contact.a];
  MovingBody& b = bodies[contact.b];
  a.v += a.inverse_mass * p;
  a.w += a.inverse_inertia * contact.arm_a.cross(p);
  b.v -= b.inverse_mass * p;
  b.w -= b.inverse_inertia * contact.arm_b.cross(p);
}

[[gnu::flatten]] void World::apply_impulses() {
  for (const StepContact& contact : contacts) change(contact, contact.impulse);
}

void World::clear_impulses() {
  for (StepContact& contact : contacts) contact.impulse.setZero();
}

void World::nudge(StepContact& contact, const Vector3d& p) {
  MovingBody& a = bodies[contact.a];
  MovingBody& b = bodies[contact.b];
  a.shift += a.inverse_mass * p;
  b.shift -= b.inverse_mass * p;
  turn(a, a.inverse_inertia * contact.arm_a.cross(p));
  turn(b, b.inverse_inertia * -contact.arm_b.cross(p));
  update(contact);
}

double World::inverse_mass_along(const StepContact& contact, const Vector3d& direction) const {
  const auto of = [&](const MovingBody& body, const Vector3d& arm) {
    const Vector3d moment = arm.cross(direction);
    return body.inverse_mass + moment.dot(body.inverse_inertia * moment);
  };
  return of(bodies[contact.a], contact.arm_a) + of(bodies[contact.b], contact.arm_b);
}

void World::project_positions(const Projection& projection) {
  constexpr double kFarthest = 0.2;  // m, of one correction
  for (std::int64_t i = 0; i < projection.position_iterations; ++i) {
    for (StepContact& contact : contacts) {
      update(contact);
      const double error = std::clamp(projection.share * (contact.gap + projection.slop), -kFarthest, 0.0);
      const Vector3d normal = contact.frame.row(0);
      if (error < 0) nudge(contact, -error / inverse_mass_along(contact, normal) * normal);
    }
  }
}

void World::write(double h, StepAnswer& answer) const {
  const auto count = static_cast<Index>(bodies.size()) - 1;
  answer.velocity.resize(6 * count);
  answer.correction.resize(6 * count);
  answer.substeps = moves;
  for (Index i = 0; i < count; ++i) {
    const MovingBody& body = bodies[static_cast<std::size_t>(i)];
    answer.velocity.segment<3>(6 * i) = body.v;
    answer.velocity.segment<3>(6 * i + 3) = body.w;
    answer.correction.segment<3>(6 * i) = body.shift - h * body.v;
    answer.correction.segment<3>(6 * i + 3) = rotation_vector(body.turn) - h * body.w;
  }
}

void BodyStepper::step(const StepProblem& problem, StepAnswer& answer) {
  answer = {};
  if (!std::holds_alternative<RigidScene>(problem.contacts)) {
    answer.claim = Claim::kUnsupported;
    answer.detail = "it knows free bodies only, and the scene has joints";
    return;
  }
  world_.load(problem);
  bool sorted = false;
  for (StepContact& contact : world_.contacts) {
    const ContactId id = problem.ids[contact.number];
    auto known = impulses_.begin() + static_cast<std::ptrdiff_t>(std::min(contact.number, impulses_.size()));
    if (known == impulses_.end() || known->first != id) {
      if (!sorted) {
        std::sort(impulses_.begin(), impulses_.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
      }
      sorted = true;
      known = std::lower_bound(impulses_.begin(), impulses_.end(), id,
                               [](const auto& each, ContactId other) { return each.first < other; });
      if (known == impulses_.end() || known->first != id) continue;
    }
    contact.impulse = contact.frame * known->second;
    // Where the normal has turned, the last impulse has tangential parts. Without friction no sweep changes these.
    if (contact.mu == 0) contact.impulse.tail<2>().setZero();
  }
  run(world_, problem.h);
  impulses_.clear();
  world_.write(problem.h, answer);
  if (!answer.velocity.allFinite() || !answer.correction.allFinite()) {
    answer = {};
    answer.detail = "its velocities are not finite";
    return;
  }
  answer.claim = Claim::kIterationLimit;
  impulses_.resize(world_.contacts.size());
  for (const StepContact& contact : world_.contacts) {
    impulses_[contact.number] = {problem.ids[contact.number], contact.frame.transpose() * contact.impulse};
  }
}

}  // namespace lcpbench::steppers
