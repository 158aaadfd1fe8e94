// Siconos's semismooth Newton method, SICONOS_LCP_NEWTON_FB_FBLSA.
#include "adapters/siconos/siconos_common.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
extern "C" {
#include <lcp_cst.h>
}
#endif

namespace lcpbench {
namespace {

struct SiconosNewtonFbSettings {
  static constexpr Capabilities capabilities{
      .guarantees = "none: a stationary point of the merit function may be no solution", .warm_start = true};
#ifndef LCPBENCH_DESCRIBE_ONLY
  static constexpr int solver = SICONOS_LCP_NEWTON_FB_FBLSA;
#endif
  double tolerance = 1e-10;
  std::int64_t max_iterations = 1000;

  void visit(auto&& field) {
    field("tolerance", tolerance, RealRange{.min = 0.0, .max = 1.0},
          "on the Fischer-Burmeister merit function; 1e-10 is Siconos's default");
    field("max_iterations", max_iterations, IntegerRange{.min = 1, .max = 1000000000},
          "Newton steps at most; 1000 is Siconos's default");
  }
};

}  // namespace

SolverDefinition lcpbench_solver_siconos_newton_fb() {
  return define_siconos<SiconosNewtonFbSettings>(
      {.name = "siconos_newton_fb",
       .summary = "Siconos's Newton method on the Fischer-Burmeister function with a line search",
       .source = "Siconos, numerics/src/LCP; after De Luca, Facchinei, Kanzow 1996, Math. Program. 75"});
}

}  // namespace lcpbench
