// Siconos's projected Gauss-Seidel method, SICONOS_LCP_PGS.
#include "adapters/siconos/siconos_common.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
extern "C" {
#include <lcp_cst.h>
}
#endif

namespace lcpbench {
namespace {

struct SiconosPgsSettings {
  static constexpr Capabilities capabilities{
      .frictionless_only = true, .guarantees = "symmetric positive definite M", .warm_start = true};
#ifndef LCPBENCH_DESCRIBE_ONLY
  static constexpr int solver = SICONOS_LCP_PGS;
#endif
  double tolerance = 1e-6;
  std::int64_t max_iterations = 10000;

  void visit(auto&& field) {
    field("tolerance", tolerance, RealRange{.min = 0.0, .max = 1.0},
          "the largest error of the test after each sweep; 1e-6 is Siconos's default");
    field("max_iterations", max_iterations, IntegerRange{.min = 1, .max = 1000000000},
          "sweeps at most; 10000 is Siconos's default");
  }
};

}  // namespace

SolverDefinition lcpbench_solver_siconos_pgs() {
  return define_siconos<SiconosPgsSettings>(
      {.name = "siconos_pgs",
       .summary = "Siconos's projected Gauss-Seidel method (frictionless problems)",
       .source = "Siconos, numerics/src/LCP/lcp_pgs.c; after Cottle, Pang, Stone 1992"});
}

}  // namespace lcpbench
