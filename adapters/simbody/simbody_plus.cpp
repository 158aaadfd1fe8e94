// Simbody's PLUSImpulseSolver (Poisson, Lankarani, Uchida, Sherman): Newton steps on a guessed set of active rows.
#include "adapters/simbody/simbody_common.h"

namespace lcpbench {
namespace {

struct SimbodyPlusSettings {
  static constexpr Capabilities capabilities{.frictionless_only = true,
                                             .friction_setting = "cone=true",
                                             .guarantees = "none: the guesses of the active rows may not end"};
  bool cone = false;
  double tolerance = 1e-10;
  std::int64_t max_iterations = 20;
  double slip_speed = 1e-2;

  void visit(auto&& field) {
    field("cone", cone, kConeHelp);
    field("tolerance", tolerance, RealRange{.min = 0.0}, "of its Newton steps; 1e-10 is Simbody's default");
    field("max_iterations", max_iterations, IntegerRange{.min = 1, .max = 1000000000},
          "Newton steps at most; 20 is Simbody's default");
    field("slip_speed", slip_speed, RealRange{.min = 0.0},
          "a contact that begins slower may roll [m/s]; Simbody's constructor has no default");
  }
#ifndef LCPBENCH_DESCRIBE_ONLY
  simbody::Request request() const {
    return {simbody::Method::kPlus, tolerance, static_cast<int>(max_iterations), slip_speed};
  }
#endif
};

}  // namespace

SolverDefinition lcpbench_solver_simbody_plus() {
  return define_simbody<SimbodyPlusSettings>(
      {.name = "simbody_plus",
       .summary = "Simbody's PLUSImpulseSolver, with the round friction cone if cone=true",
       .source = "Simbody, simbody/internal/PLUSImpulseSolver.h; Uchida, Sherman, Delp 2015, Proc. R. Soc. A 471"});
}

}  // namespace lcpbench
