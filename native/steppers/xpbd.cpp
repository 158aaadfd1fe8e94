#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "native/steppers/define_stepper.h"
#include "native/steppers/world.h"

namespace lcpbench {
namespace {

using steppers::MovingBody;
using steppers::StepContact;
using steppers::Vector3d;
using steppers::World;

struct XpbdSettings {
  std::int64_t substeps = 20;
  std::int64_t iterations = 1;
  double compliance = 0;
  double slop = 1e-4;
  double push_speed = 3;

  void visit(auto&& field) {
    field("substeps", substeps, IntegerRange{.min = 1}, "equal parts of the step");
    field("iterations", iterations, IntegerRange{.min = 1}, "sweeps over the positions in each substep");
    field("compliance", compliance, RealRange{.min = 0}, "[m/N] of a contact's normal");
    field("slop", slop, RealRange{.min = 0},
          "[m] penetration that is left alone: some engines find a contact only where bodies overlap");
    field("push_speed", push_speed, RealRange{.min = 0}, "[m/s] the fastest that penetration is pushed out");
  }
};

/// Extended position-based dynamics of rigid bodies (Mueller et al., Detailed rigid body simulation with extended
/// position based dynamics, 2020, Algorithm 2). The velocities are the change of the positions. Friction that holds is
/// a constraint on positions, friction that slides one on velocities; what it may take is limited as an impulse (the
/// paper's equation 30 compares an impulse with a speed).
class Xpbd final : public steppers::BodyStepper {
 public:
  explicit Xpbd(const XpbdSettings& settings) : settings_(settings) {}

 protected:
  void run(World& world, double h) override {
    const double dt = h / static_cast<double>(settings_.substeps);
    for (std::int64_t substep = 0; substep < settings_.substeps; ++substep) {
      world.push(dt / h);
      const std::vector<MovingBody> before = world.bodies;
      places_.clear();
      for (const StepContact& contact : world.contacts) places_.push_back(world.apart(contact));
      world.clear_impulses();
      world.move(dt);
      for (std::int64_t i = 0; i < settings_.iterations; ++i) {
        for (std::size_t k = 0; k < places_.size(); ++k) solve_position(world, world.contacts[k], places_[k], dt);
      }
      world.update_contacts();
      for (std::size_t i = 0; i < before.size(); ++i) {
        MovingBody& body = world.bodies[i];
        const Eigen::Quaterniond turn = body.turn * before[i].turn.conjugate();
        body.v = (body.shift - before[i].shift) / dt;
        body.w = (turn.w() < 0 ? -2 : 2) / dt * turn.vec();
      }
      for (StepContact& contact : world.contacts) {
        if (contact.impulse(0) > 0) solve_velocity(world, contact, std::exchange(contact.bounce, 0), dt);
      }
    }
    world.clear_impulses();
  }

 private:
  /// Here StepContact::impulse holds sums over the substep [kg m]: of corrections along the normal, of lengths across
  /// it. @param place  World::apart() at the beginning of the substep
  void solve_position(World& world, StepContact& contact, const Vector3d& place, double dt) const {
    world.update(contact);
    const Vector3d normal = contact.frame.row(0);
    const double soft = settings_.compliance / (dt * dt);
    // What is deeper than the substep's motion explains comes out slowly.
    const double motion = normal.dot(world.apart(contact) - place);
    const double gap = std::max(contact.gap + settings_.slop, std::min(motion, 0.0) - settings_.push_speed * dt);
    const double change = std::max(
        -(gap + soft * contact.impulse(0)) / (world.inverse_mass_along(contact, normal) + soft), -contact.impulse(0));
    if (gap >= 0 && contact.impulse(0) == 0) return;
    contact.impulse(0) += change;
    world.nudge(contact, change * normal);
    Vector3d slid = world.apart(contact) - place;
    slid -= normal.dot(slid) * normal;
    const double way = slid.norm();
    if (way == 0) return;
    const double needed = way / world.inverse_mass_along(contact, slid / way);
    if (contact.impulse(1) + needed > contact.mu * contact.impulse(0)) return;
    contact.impulse(1) += needed;
    world.nudge(contact, -needed / way * slid);
  }

  static void solve_velocity(World& world, const StepContact& contact, double bounce, double dt) {
    const auto change = [&](const Vector3d& wanted, double limit) {
      const double speed = wanted.norm();
      if (speed == 0) return;
      const double impulse =
          std::min(speed / world.inverse_mass_along(contact, contact.frame.transpose() * wanted / speed), limit);
      world.apply(contact, impulse / speed * wanted);
    };
    Vector3d sliding = -world.relative_velocity(contact);
    sliding(0) = 0;
    change(sliding, contact.mu * contact.impulse(0) / dt);
    change({bounce - world.relative_velocity(contact)(0), 0, 0}, std::numeric_limits<double>::infinity());
  }

  XpbdSettings settings_;
  std::vector<Vector3d> places_;
};

}  // namespace

StepperDefinition lcpbench_stepper_xpbd() {
  return define_stepper<Xpbd, XpbdSettings>(
      {.name = "xpbd",
       .summary = "extended position-based dynamics: positions are corrected, velocities follow; with substeps",
       .source = "Mueller et al., Detailed rigid body simulation with extended position based dynamics, 2020"});
}

}  // namespace lcpbench
