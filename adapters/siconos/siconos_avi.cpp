// Siconos's solver of affine variational inequalities on the LCP, SICONOS_LCP_AVI_CAOFERRIS.
#include "adapters/siconos/siconos_common.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
extern "C" {
#include <lcp_cst.h>
}
#endif

namespace lcpbench {
namespace {

struct SiconosAviSettings {
  static constexpr Capabilities capabilities{.guarantees = "copositive-plus M when the problem is feasible"};
#ifndef LCPBENCH_DESCRIBE_ONLY
  static constexpr int solver = SICONOS_LCP_AVI_CAOFERRIS;
#endif
  double tolerance = 1e-12;
  std::int64_t max_iterations = 10000;

  void visit(auto&& field) {
    field("tolerance", tolerance, RealRange{.min = 0.0, .max = 1.0}, "on the pivots; 1e-12 is Siconos's default");
    field("max_iterations", max_iterations, IntegerRange{.min = 1, .max = 1000000000},
          "pivots at most; 10000 is Siconos's default");
  }
};

}  // namespace

SolverDefinition lcpbench_solver_siconos_avi() {
  return define_siconos<SiconosAviSettings>(
      {.name = "siconos_avi",
       .summary = "Siconos's pivotal method for affine variational inequalities on (q, M)",
       .source = "Siconos, numerics/src/AVI; after Cao, Ferris 1996, Math. Oper. Res. 21"});
}

}  // namespace lcpbench
