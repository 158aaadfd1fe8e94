// ODE's dWorldQuickStep, the real one, on a rigid scene.
//
// One step of length 1 s with error reduction, damping, gravity and gyroscopic terms off: force then equals impulse,
// and the step iterates on the rows of the scene's LCP (see OdeWorld), with cfm added to their diagonal.
#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include "adapters/ode/ode_world.h"
#include "adapters/worker/self_timed.h"
#endif

namespace lcpbench {
namespace {

constexpr Capabilities kOdeQuickstepCapabilities{.needs = Needs::kScene,
                                     .guarantees =
                                         "converges for symmetric positive semidefinite M (no friction), "
                                         "0 < w < 2; with friction none"};

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

class OdeQuickstep;

#ifndef LCPBENCH_DESCRIBE_ONLY

class OdeQuickstep final : public Solver, public SelfTimed {
 public:
  explicit OdeQuickstep(const OdeQuickstepSettings& settings) : settings_(settings), iterations_(settings.iterations) {
    start_ode();
  }
  const Capabilities& capabilities() const override { return kOdeQuickstepCapabilities; }
  bool usable() const override { return true; }

  /// A step does more than solve: it finds islands, forms rows, moves bodies. A step of no iterations does all that and
  /// nothing else: its time is counted as set-up, and the time of the solve is what the iterations add.
  void run(const Problem& problem, const TimedRequest& request, TimedAnswer& result) override {
    iterations_ = settings_.iterations;
    timed_solve(*this, problem, request, result);
    if (result.answer.claim == Claim::kUnsupported) return;
    iterations_ = 0;
    TimedAnswer overhead;
    timed_solve(*this, problem, request, overhead);
    SolveTimes& times = result.times;
    const SolveTimes& step = overhead.times;
    // The difference may be negative, because both times are measured with noise.
    times.solve_wall_s = std::max(0.0, times.solve_wall_s - step.solve_wall_s);
    times.solve_cpu_s = std::max(0.0, times.solve_cpu_s - step.solve_cpu_s);
    times.setup_wall_s += step.solve_wall_s;
    times.setup_cpu_s += step.solve_cpu_s;
  }

 protected:
  void on_load(const Problem& problem) override {
    world_ = std::make_unique<OdeWorld>(*problem.scene(), settings_.cfm);
    dWorldSetQuickStepNumIterations(world_->id(), static_cast<int>(iterations_));
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
    world_->read(scene, answer.z);
    answer.counters.iterations = iterations_;
    answer.detail = take_ode_message();
    // QuickStep has no test of convergence and no way to say that it failed: a finished step is its claim.
    if (answer.detail.empty()) answer.claim = Claim::kSolved;
  }

 private:
  OdeQuickstepSettings settings_;
  std::int64_t iterations_;  // of the next load
  std::unique_ptr<OdeWorld> world_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_ode_quickstep() {
  return define_adapter<OdeQuickstep, OdeQuickstepSettings>(
      {.name = "ode_quickstep",
       .summary = "ODE's dWorldQuickStep on the rigid scene (projected successive over-relaxation)",
       .source = "Open Dynamics Engine; a finished step counts as a claim, it has no failure",
       .capabilities = kOdeQuickstepCapabilities});
}

}  // namespace lcpbench
