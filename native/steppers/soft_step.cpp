#include <algorithm>
#include <numbers>
#include <vector>

#include "native/steppers/define_stepper.h"
#include "native/steppers/world.h"

namespace lcpbench {
namespace {

struct SoftStepSettings {
  std::int64_t substeps = 4;
  double hertz = 30;
  double damping_ratio = 10;
  bool relax = true;
  double push_speed = 3;
  bool update_gaps = true;

  void visit(auto&& field) {
    field("substeps", substeps, IntegerRange{.min = 1}, "equal parts of the step");
    field(
        "hertz", hertz, RealRange{.min = 0},
        "frequency of a contact's spring, at most a quarter of the substeps per second; twice that against the world");
    field("damping_ratio", damping_ratio, RealRange{.min = 0}, "of that spring");
    field("relax", relax, "a second sweep after the positions have moved, in which contacts do not push out");
    field("push_speed", push_speed, RealRange{.min = 0}, "[m/s] the fastest that penetration is pushed out");
    field("update_gaps", update_gaps, "false: all substeps take the gap at which the step began");
  }
};

/// Soft step: substeps of one sweep each with soft contacts, then one without their push (Catto, Solver2D, 2024;
/// b2SolverStage of Box2D 3). Restitution comes at the end of the step.
class SoftStep final : public steppers::BodyStepper {
 public:
  explicit SoftStep(const SoftStepSettings& settings) : settings_(settings) {}

 protected:
  void run(steppers::World& world, double h) override {
    const double dt = h / static_cast<double>(settings_.substeps);
    const std::size_t ground = world.bodies.size() - 1;
    const double hertz = std::min(settings_.hertz, 0.25 / dt);
    const Soft soft(hertz, settings_.damping_ratio, dt);
    const Soft stiff(2 * hertz, settings_.damping_ratio, dt);
    const auto demand = [&](const steppers::StepContact& contact) {
      const double gap = settings_.update_gaps ? contact.gap : contact.start_gap;
      if (gap > 0) return steppers::Demand{gap / dt};
      const Soft& spring = contact.b == ground ? stiff : soft;
      return steppers::Demand{std::max(spring.rate * gap, -settings_.push_speed), spring.mass, spring.impulse};
    };
    const auto rest = [&](const steppers::StepContact& contact) {
      return steppers::Demand{std::max(0.0, settings_.update_gaps ? contact.gap : contact.start_gap) / dt};
    };
    std::vector<bool> met(world.contacts.size());  // in any substep: a body that has come to rest needs no impulse
    for (std::int64_t substep = 0; substep < settings_.substeps; ++substep) {
      world.push(dt / h);
      world.apply_impulses();
      world.sweep(demand);
      for (std::size_t i = 0; i < met.size(); ++i) met[i] = met[i] || world.contacts[i].impulse(0) > 0;
      world.move(dt);
      if (settings_.relax) world.sweep(rest);
    }
    for (std::size_t i = 0; i < met.size(); ++i) {
      steppers::StepContact& contact = world.contacts[i];
      if (contact.bounce > 0 && met[i]) world.solve(contact, {-contact.bounce}, false);
    }
  }

 private:
  struct Soft {
    Soft(double hertz, double damping_ratio, double dt) {
      const double omega = 2 * std::numbers::pi * hertz;
      const double a1 = 2 * damping_ratio + dt * omega;
      const double a2 = dt * omega * a1;
      rate = a1 > 0 ? omega / a1 : 0;
      impulse = 1 / (1 + a2);
      mass = a2 * impulse;
    }
    double rate;  ///< of the bias velocity to the penetration [1/s]
    double mass;
    double impulse;
  };

  SoftStepSettings settings_;
};

}  // namespace

StepperDefinition lcpbench_stepper_soft_step() {
  return define_stepper<SoftStep, SoftStepSettings>(
      {.name = "soft_step",
       .summary = "substeps of one sweep with soft contacts and one that relaxes them, as Box2D 3",
       .source = "Catto, Solver2D, 2024; Box2D 3"});
}

}  // namespace lcpbench
