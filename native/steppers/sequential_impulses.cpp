#include "native/steppers/define_stepper.h"
#include "native/steppers/world.h"

namespace lcpbench {
namespace {

struct SequentialImpulsesSettings {
  std::int64_t iterations = 8;
  steppers::Projection projection{.slop = 0.005};  // as Box2D
  bool warm = true;

  void visit(auto&& field) {
    field("iterations", iterations, IntegerRange{.min = 1}, "sweeps over the velocities");
    field("warm", warm, "start from the impulses of the step before, by contact");
    projection.visit(field);
  }
};

/// Sequential impulses: a few warm sweeps over the velocities, then a few over the positions, in which contacts are
/// brought to where the bodies are (Catto, Iterative dynamics with temporal coherence, 2005; Box2D 2.4,
/// b2ContactSolver). Bullet's solver differs: its sweeps over positions work on a second velocity.
class SequentialImpulses final : public steppers::BodyStepper {
 public:
  explicit SequentialImpulses(const SequentialImpulsesSettings& settings) : settings_(settings) {}

 protected:
  void run(steppers::World& world, double h) override {
    world.push(1);
    if (!settings_.warm) world.clear_impulses();
    world.apply_impulses();
    const auto demand = [&](const steppers::StepContact& contact) {
      return steppers::Demand{steppers::velocity_bias(contact, h, 0)};
    };
    for (std::int64_t i = 0; i < settings_.iterations; ++i) world.sweep(demand);
    world.move(h);
    world.project_positions(settings_.projection);
  }

 private:
  SequentialImpulsesSettings settings_;
};

}  // namespace

StepperDefinition lcpbench_stepper_sequential_impulses() {
  return define_stepper<SequentialImpulses, SequentialImpulsesSettings>(
      {.name = "sequential_impulses",
       .summary = "warm Gauss-Seidel sweeps over velocities, then sweeps over positions, as Box2D 2.4",
       .source = "Catto, Iterative dynamics with temporal coherence, 2005; Box2D 2.4"});
}

}  // namespace lcpbench
