// ODE's dWorldStep on a rigid scene: its Dantzig solver on a matrix that it forms itself.
//
// With friction it solves another problem than ours (limits from a solve of the normals alone), so frictionless only.
#include "core/registry.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include "adapters/ode_world.h"
#endif

namespace lcpbench {
namespace {

constexpr Capabilities kCapabilities{
    .needs = Needs::kScene, .frictionless_only = true, .guarantees = "symmetric positive definite M + cfm I"};

struct OdeStepSettings {
  double cfm = 0.0;

  void visit(auto&& field) {
    field("cfm", cfm, RealRange{.min = 0.0}, "constraint force mixing: solves M + cfm I; ODE's default is 1e-10");
  }
};

#ifndef LCPBENCH_DESCRIBE_ONLY

class OdeStep final : public Solver {
 public:
  explicit OdeStep(const OdeStepSettings& settings) : settings_(settings) { start_ode(); }
  const Capabilities& capabilities() const override { return kCapabilities; }

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
    for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
      answer.z(static_cast<Index>(i)) = world_->normal_impulse(i, scene.contacts[i].normal);
    }
    answer.detail = take_ode_message();  // "LCP internal error" comes this way, and no other
    if (answer.detail.empty()) answer.claim = Claim::kSolved;
  }

 private:
  OdeStepSettings settings_;
  std::unique_ptr<OdeWorld> world_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_ode_step() {
  SolverDefinition definition{.name = "ode_step",
                              .summary = "ODE's dWorldStep on the rigid scene (Dantzig's principal pivoting)",
                              .source = "Open Dynamics Engine; after Baraff, SIGGRAPH 1994",
                              .capabilities = kCapabilities};
#ifdef LCPBENCH_DESCRIBE_ONLY
  return with_settings<OdeStepSettings>(std::move(definition));
#else
  return define_solver<OdeStep, OdeStepSettings>(std::move(definition));
#endif
}

}  // namespace lcpbench
