#include "native/steppers/define_stepper.h"
#include "native/steppers/world.h"

namespace lcpbench {
namespace {

struct PgsSettings {
  std::int64_t iterations = 10;
  std::int64_t substeps = 1;
  double erp = 0.2;
  bool warm = true;

  void visit(auto&& field) {
    field("iterations", iterations, IntegerRange{.min = 1}, "sweeps of each substep");
    field("substeps", substeps, IntegerRange{.min = 1}, "equal parts of the step; the gaps are updated after each");
    field("erp", erp, RealRange{.min = 0, .max = 1}, "share of a penetration that the velocity takes back in a step");
    field("warm", warm, "start from the impulses of the substep before, by contact");
  }
};

/// Projected Gauss-Seidel with Baumgarte's correction of positions: what ODE's QuickStep does (Smith, ODE's manual,
/// section 3.8), with the round cone and, by `substeps`, as Macklin et al. (Small steps in physics simulation, 2019)
/// split a step.
class Pgs final : public steppers::BodyStepper {
 public:
  explicit Pgs(const PgsSettings& settings) : settings_(settings) {}

 protected:
  void run(steppers::World& world, double h) override {
    const double dt = h / static_cast<double>(settings_.substeps);
    for (std::int64_t substep = 0; substep < settings_.substeps; ++substep) {
      world.push(dt / h);
      if (!settings_.warm) world.clear_impulses();
      world.apply_impulses();
      const auto demand = [&](const steppers::StepContact& contact) {
        return steppers::Demand{steppers::velocity_bias(contact, dt, settings_.erp * dt / h, substep == 0)};
      };
      for (std::int64_t i = 0; i < settings_.iterations; ++i) world.sweep(demand);
      world.move(dt);
    }
  }

 private:
  PgsSettings settings_;
};

}  // namespace

StepperDefinition lcpbench_stepper_pgs() {
  return define_stepper<Pgs, PgsSettings>(
      {.name = "pgs",
       .summary = "projected Gauss-Seidel from the last impulses, penetration taken back by velocity; with substeps",
       .source =
           "Smith, Open Dynamics Engine, 2006; substeps: Macklin et al., Small steps in physics simulation, 2019"});
}

}  // namespace lcpbench
