// ODE's dWorldQuickStep, the real one, on a rigid scene.
//
// One step of length 1 s with error reduction, damping, gravity and gyroscopic terms off: force then equals impulse,
// and the step solves exactly the scene's frictionless LCP, with M + cfm I for M.
#include "core/registry.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include "adapters/ode_world.h"
#endif

namespace lcpbench {
namespace {

constexpr Capabilities kCapabilities{.needs = Needs::kScene,
                                     .frictionless_only = true,
                                     .guarantees = "converges for symmetric positive semidefinite M, 0 < w < 2"};

struct OdeQuickstepSettings {
  std::int64_t iterations = 20;
  double w = 1.3;
  double cfm = 0.0;
  std::int64_t seed = 0;

  void visit(auto&& field) {
    field("iterations", iterations, IntegerRange{.min = 0, .max = 1000000000},
          "sweeps over the constraints (dWorldSetQuickStepNumIterations); 20 is ODE's default");
    field("w", w, RealRange{.min = 1e-6, .max = 2.0}, "over-relaxation (dWorldSetQuickStepW); 1.3 is ODE's default");
    field("cfm", cfm, RealRange{.min = 0.0}, "constraint force mixing: solves M + cfm I; ODE's default is 1e-10");
    field("seed", seed, IntegerRange{.min = 0, .max = 4294967295},
          "of ODE's random numbers, which order the constraints");
  }
};

#ifndef LCPBENCH_DESCRIBE_ONLY

class OdeQuickstep final : public Solver {
 public:
  explicit OdeQuickstep(const OdeQuickstepSettings& settings) : settings_(settings) { start_ode(); }
  const Capabilities& capabilities() const override { return kCapabilities; }

 protected:
  void on_load(const Problem& problem) override {
    world_ = std::make_unique<OdeWorld>(*problem.scene(), settings_.cfm);
    dWorldSetQuickStepNumIterations(world_->id(), static_cast<int>(settings_.iterations));
    dWorldSetQuickStepW(world_->id(), settings_.w);
  }

  void on_solve(const SolveRequest&, Answer& answer) override {
    const RigidScene& scene = *problem().scene();
    take_ode_message();
    dRandSetSeed(static_cast<unsigned long>(settings_.seed));
    world_->reset(scene);
    if (dWorldQuickStep(world_->id(), 1.0) == 0) {
      answer.detail = "dWorldQuickStep failed";
      return;
    }
    for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
      answer.z(static_cast<Index>(i)) = world_->normal_impulse(i, scene.contacts[i].normal);
    }
    answer.counters.iterations = settings_.iterations;
    answer.detail = take_ode_message();
    // QuickStep has no test of convergence and no way to say that it failed: a finished step is its claim.
    if (answer.detail.empty()) answer.claim = Claim::kSolved;
  }

 private:
  OdeQuickstepSettings settings_;
  std::unique_ptr<OdeWorld> world_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_ode_quickstep() {
  SolverDefinition definition{
      .name = "ode_quickstep",
      .summary = "ODE's dWorldQuickStep on the rigid scene (projected successive over-relaxation)",
      .source = "Open Dynamics Engine; a finished step counts as a claim, it has no failure",
      .capabilities = kCapabilities};
#ifdef LCPBENCH_DESCRIBE_ONLY
  return with_settings<OdeQuickstepSettings>(std::move(definition));
#else
  return define_solver<OdeQuickstep, OdeQuickstepSettings>(std::move(definition));
#endif
}

}  // namespace lcpbench
