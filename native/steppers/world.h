#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>
#include <vector>

#include "core/stepper.h"

namespace lcpbench::steppers {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct MovingBody {
  double inverse_mass = 0;
  Matrix3d inverse_inertia = Matrix3d::Zero();
  Vector3d v = Vector3d::Zero();
  Vector3d w = Vector3d::Zero();
  Vector3d force_v = Vector3d::Zero();  ///< what the forces of the whole step add to v, and to w
  Vector3d force_w = Vector3d::Zero();
  Vector3d shift = Vector3d::Zero();                         ///< [m] of the centre since the step began
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  ///< rotation since then, in the axes of the world
  Matrix3d rotation = Matrix3d::Identity();                  ///< the same
};

/// A contact whose point is fixed in both bodies and whose normal is fixed in space during the step.
struct StepContact {
  std::size_t number = 0;  ///< in the scene
  std::size_t a = 0;
  std::size_t b = 0;  ///< the world is a body that cannot move, the last one
  Matrix3d frame;     ///< rows: normal from b into a, tangent, second tangent
  Vector3d start_a;   ///< from the centre of a to the point at the beginning of the step
  Vector3d start_b;   ///< from the centre of b
  Vector3d arm_a;     ///< start_a, turned with the body since then
  Vector3d arm_b;
  double start_gap = 0;  ///< [m] at the beginning of the step; negative: penetration
  double gap = 0;        ///< [m] now
  double mu = 0;
  double bounce = 0;                    ///< [m/s] the normal velocity after a bounce, 0 where it does not bounce
  Vector3d impulse = Vector3d::Zero();  ///< [N s] along the rows of the frame
  Matrix3d lever_a;                     ///< columns: arm_a x each row of the frame
  Matrix3d lever_b;
  Matrix3d turn_a;                     ///< change of w that a unit impulse along each row makes
  Matrix3d turn_b;                     ///< of b, which gets the opposite impulse: -turn_b
  Eigen::Vector2d normal_to_tangents;  ///< change of the tangential velocity that a unit normal impulse makes
  double normal_mass = 0;
  double tangent_mass = 0;  ///< of the tangent direction that is easiest to move
};

/// What a sweep asks of the normal velocity at a contact: velocity + bias >= 0 [m/s]. Soft contacts yield (Catto 2011):
/// with m = normal_mass the impulse changes by -mass_scale m (velocity + bias) - impulse_scale impulse.
struct Demand {
  double bias = 0;
  double mass_scale = 1;
  double impulse_scale = 0;
};

/// How positions are corrected after the velocities.
struct Projection {
  std::int64_t position_iterations = 3;
  double slop = 1e-4;
  double share = 0.2;

  void visit(auto&& field) {
    field("position_iterations", position_iterations, IntegerRange{.min = 0}, "sweeps over the positions");
    field("slop", slop, RealRange{.min = 0}, "[m] penetration that is left alone");
    field("share", share, RealRange{.min = 0, .max = 1}, "of a deeper penetration that a sweep takes back");
  }
};

/// The bodies and contacts of a step, as all steppers of free bodies lay them out.
class World {
 public:
  std::vector<MovingBody> bodies;
  /// Each body has its contacts in the scene's order. Between two of them stand as many as can of other bodies: the
  /// processor then works on several at once.
  std::vector<StepContact> contacts;
  int moves = 0;  ///< since load()

  /// Velocities without the forces of the step. @pre the step has free bodies
  void load(const StepProblem& problem);

  /// Adds this share of force_v and force_w to the velocities.
  void push(double share);
  /// Moves the bodies along their velocities, and brings the contacts to where they are then.
  void move(double dt);
  /// Sets arms and gap for the bodies' present positions. The gap is linear in apart(): the normal does not turn.
  void update(StepContact& contact) const;
  void update_contacts();
  /// Motion of the point of a relative to that of b since the step began [m], in the axes of the world.
  Vector3d apart(const StepContact& contact) const;

  Vector3d relative_velocity(const StepContact& contact) const;     ///< in the contact's frame
  void apply(const StepContact& contact, const Vector3d& impulse);  ///< in the contact's frame
  /// Applies the impulses that the contacts have.
  void apply_impulses();
  void clear_impulses();

  /// One Gauss-Seidel sweep with the round cone: of each contact first the normal, then both tangents at once. The
  /// levers are those of load() and of the last move().
  template <class Rule>
  void sweep(Rule&& rule) {
    for (StepContact& contact : contacts) {
      solve(contact, rule(static_cast<const StepContact&>(contact)), contact.mu > 0);
    }
  }
  void solve(StepContact& contact, const Demand& demand, bool friction);

  /// Moves the bodies' positions as an impulse moves their velocities, and the contact with them.
  void nudge(StepContact& contact, const Vector3d& world_impulse);
  double inverse_mass_along(const StepContact& contact, const Vector3d& direction) const;
  /// Takes penetration back, contact after contact.
  void project_positions(const Projection& projection);

  void write(double h, StepAnswer& answer) const;

 private:
  void set_order(const RigidScene& scene);
  void set_levers(StepContact& contact) const;
  /// apply() with the levers.
  void change(const StepContact& contact, const Vector3d& impulse);

  std::vector<std::size_t> turns_, next_turn_, begins_;  // scratch of set_order()
};

// Contacts of one body are solved one after the other: what counts is how long a contact takes from the velocities that
// it reads to those that it writes. So the velocity is read once, and friction knows what the normal impulse does to
// it.
[[gnu::flatten]] inline void World::solve(StepContact& contact, const Demand& demand, bool friction) {
  const MovingBody& a = bodies[contact.a];
  const MovingBody& b = bodies[contact.b];
  const Vector3d u =
      contact.frame * (a.v - b.v) + contact.lever_a.transpose() * a.w - contact.lever_b.transpose() * b.w;
  Vector3d now = contact.impulse;
  now(0) = std::max(
      0.0, now(0) - contact.normal_mass * demand.mass_scale * (u(0) + demand.bias) - demand.impulse_scale * now(0));
  if (friction) {
    now.tail<2>() -= contact.tangent_mass * (u.tail<2>() + contact.normal_to_tangents * (now(0) - contact.impulse(0)));
    const double limit = contact.mu * now(0);
    if (now.tail<2>().squaredNorm() > limit * limit) now.tail<2>() *= limit / now.tail<2>().norm();
  }
  const Vector3d more = now - contact.impulse;
  contact.impulse = now;
  change(contact, more);
}

inline void World::change(const StepContact& contact, const Vector3d& impulse) {
  MovingBody& a = bodies[contact.a];
  MovingBody& b = bodies[contact.b];
  const Vector3d p = contact.frame.transpose() * impulse;
  a.v += a.inverse_mass * p;
  a.w += contact.turn_a * impulse;
  b.v -= b.inverse_mass * p;
  b.w -= contact.turn_b * impulse;
}

/// Demand::bias: gap / dt of an open contact; else what takes `erp` of the penetration back in dt, or bounces.
inline double velocity_bias(const StepContact& contact, double dt, double erp, bool bounces = true) {
  if (contact.gap > 0) return contact.gap / dt;
  return std::min(erp * contact.gap / dt, bounces ? -contact.bounce : 0.0);
}

/// A stepper of free bodies: refuses scenes with joints, and keeps the impulses by contact from step to step, but none
/// of a step whose velocities are not finite. It claims kIterationLimit.
class BodyStepper : public Stepper {
 public:
  void step(const StepProblem& problem, StepAnswer& answer) final;

 protected:
  /// @param world  velocities without the forces of the step, impulses of the step before
  virtual void run(World& world, double h) = 0;

 private:
  World world_;
  std::vector<std::pair<ContactId, Vector3d>> impulses_;  // of the step before, in the axes of the world
};

}  // namespace lcpbench::steppers
