// Simbody's PGSImpulseSolver: projected Gauss-Seidel, over-relaxed by 1.2.
#include "adapters/simbody/simbody_common.h"

namespace lcpbench {
namespace {

struct SimbodyPgsSettings {
  static constexpr Capabilities capabilities{
      .frictionless_only = true,
      .friction_setting = "cone=true",
      .guarantees = "converges for symmetric positive definite M; with friction none"};
  bool cone = false;
  double tolerance = 1e-6;
  std::int64_t max_iterations = 100;

  void visit(auto&& field) {
    field("cone", cone, kConeHelp);
    field("tolerance", tolerance, RealRange{.min = 0.0},
          "on the root mean square of the active rows' velocities [m/s]; 1e-6 is Simbody's default");
    field("max_iterations", max_iterations, IntegerRange{.min = 1, .max = 1000000000},
          "sweeps at most; 100 is Simbody's default");
  }
#ifndef LCPBENCH_DESCRIBE_ONLY
  simbody::Request request() const { return {simbody::Method::kPgs, tolerance, static_cast<int>(max_iterations), 0.0}; }
#endif
};

}  // namespace

SolverDefinition lcpbench_solver_simbody_pgs() {
  return define_simbody<SimbodyPgsSettings>(
      {.name = "simbody_pgs",
       .summary = "Simbody's PGSImpulseSolver, with the round friction cone if cone=true",
       .source = "Simbody, simbody/internal/PGSImpulseSolver.h; Sherman, Seth, Delp 2011, Procedia IUTAM 2"});
}

}  // namespace lcpbench
