// ODE's dWorldStep on a rigid scene: its Dantzig solver on a matrix that it forms itself.
//
// With friction it solves another problem than ours: the limits of the friction impulses are mu times the normal
// impulses that a solve without friction gives, and stay so. Every such answer says this in its detail.
#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include "adapters/ode/ode_world.h"
#endif

namespace lcpbench {
namespace {

constexpr Capabilities kOdeStepCapabilities{
    .needs = Needs::kScene,
    .guarantees = "symmetric positive definite M + cfm I without friction; with friction it solves another problem"};

struct OdeStepSettings {
  double cfm = 0.0;

  void visit(auto&& field) {
    field("cfm", cfm, RealRange{.min = 0.0}, "constraint force mixing: solves M + cfm I; ODE's default is 1e-10");
  }
};

class OdeStep;

#ifndef LCPBENCH_DESCRIBE_ONLY

class OdeStep final : public Solver {
 public:
  explicit OdeStep(const OdeStepSettings& settings) : settings_(settings) { start_ode(); }
  const Capabilities& capabilities() const override { return kOdeStepCapabilities; }

 protected:
  void on_load(const Problem& problem) override {
    world_ = std::make_unique<OdeWorld>(*problem.scene(), settings_.cfm);
  }

  void on_solve(const SolveRequest&, Answer& answer) override {
    const RigidScene& scene = *problem().scene();
    take_ode_message();
    dRandSetSeed(0);
    world_->reset(scene);
    if (dWorldStep(world_->id(), 1.0) == 0) {
      answer.detail = "dWorldStep failed";
      return;
    }
    world_->read(scene, answer.z);
    answer.detail = take_ode_message();  // "LCP internal error" comes this way, and no other
    if (!answer.detail.empty()) return;
    answer.claim = Claim::kSolved;
    if (problem().contact()->frictional()) {
      answer.detail = "another problem: friction limited by the normal impulses of a solve without friction";
    }
  }

 private:
  OdeStepSettings settings_;
  std::unique_ptr<OdeWorld> world_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_ode_step() {
  return define_adapter<OdeStep, OdeStepSettings>(
      {.name = "ode_step",
       .summary = "ODE's dWorldStep on the rigid scene (Dantzig's principal pivoting)",
       .source = "Open Dynamics Engine; after Baraff, SIGGRAPH 1994",
       .capabilities = kOdeStepCapabilities});
}

}  // namespace lcpbench
