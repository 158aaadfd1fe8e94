// Siconos's Lemke solver, SICONOS_LCP_LEMKE.
#include "adapters/siconos/siconos_common.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
extern "C" {
#include <lcp_cst.h>
}
#endif

namespace lcpbench {
namespace {

struct SiconosLemkeSettings {
  static constexpr Capabilities capabilities{.guarantees = "none stated by the library"};
#ifndef LCPBENCH_DESCRIBE_ONLY
  static constexpr int solver = SICONOS_LCP_LEMKE;
#endif
  double tolerance = 1e-6;
  std::int64_t max_iterations = 10000;

  void visit(auto&& field) {
    field("tolerance", tolerance, RealRange{.min = 0.0, .max = 1.0},
          "the largest error of the final test; 1e-6 is Siconos's default");
    field("max_iterations", max_iterations, IntegerRange{.min = 1, .max = 1000000000},
          "pivots at most; 10000 is Siconos's default");
  }
};

}  // namespace

SolverDefinition lcpbench_solver_siconos_lemke() {
  return define_siconos<SiconosLemkeSettings>(
      {.name = "siconos_lemke",
       .summary = "Siconos's Lemke algorithm with lexicographic ordering on (q, M)",
       .source = "Siconos, numerics/src/LCP/lcp_lexicolemke.c; after Cottle, Pang, Stone 1992"});
}

}  // namespace lcpbench
