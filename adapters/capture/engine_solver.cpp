#include <cmath>

#include "core/registry.h"

namespace lcpbench {
namespace {

constexpr Capabilities kEngineSolverCapabilities{.needs = Needs::kFactored, .compliance = true, .rows = true, .captured_only = true};

struct EngineSettings {
  FrictionModel model = FrictionModel::kPyramid;

  void visit(auto&& field) {
    field("model", model,
          Choices<FrictionModel>{{{"pyramid", FrictionModel::kPyramid},
                                  {"cone", FrictionModel::kCone},
                                  {"convex", FrictionModel::kConvex}}},
          "the friction that the engine solves, by which its answer is judged; MuJoCo's elliptic cones are convex");
  }
  FrictionModel friction_model() const { return model; }
};

/// The answer that an engine gave when the step was captured. An engine reports no failure, so the claim is always
/// `solved`.
class EngineSolver final : public Solver {
 public:
  explicit EngineSolver(const EngineSettings&) {}
  const Capabilities& capabilities() const override { return kEngineSolverCapabilities; }

 protected:
  void on_load(const Problem& problem) override {
    z_ = complete_impulses(*problem.contact(), *problem.engine_impulses());
    is_timed_ = std::isfinite(problem.engine_answer()->solve_s);
  }

  void on_solve(const SolveRequest&, Answer& answer) override {
    answer.z = z_;
    answer.claim = Claim::kSolved;
    answer.detail = is_timed_ ? "recorded, with the engine's own time" : "recorded; the time is not the engine's";
  }

 private:
  Vector z_;
  bool is_timed_ = false;
};

}  // namespace

SolverDefinition lcpbench_solver_engine() {
  return define_solver<EngineSolver, EngineSettings>(
      {.name = "engine",
       .summary = "the engine's own answer to a captured step, as its file has it",
       .source = "the engine that the step was captured from; the least lambda completes its impulses",
       .capabilities = kEngineSolverCapabilities});
}

}  // namespace lcpbench
