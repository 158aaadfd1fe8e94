// Siconos's solvers of linear complementarity problems.
#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
extern "C" {
#include <LinearComplementarityProblem.h>
#include <lcp_cst.h>
}

#include "adapters/siconos/siconos_common.h"
#endif

namespace lcpbench {
namespace {

#ifdef LCPBENCH_DESCRIBE_ONLY
/// The solvers' names without the library: only different numbers are needed.
enum SiconosLcp { SICONOS_LCP_LEMKE, SICONOS_LCP_NEWTON_FB_FBLSA, SICONOS_LCP_PGS };
#endif

constexpr Capabilities kLemke{.guarantees = "none stated by the library"};
constexpr Capabilities kNewtonFb{.guarantees = "none: a stationary point of the merit function may be no solution",
                                 .warm_start = true};
constexpr Capabilities kPgs{
    .frictionless_only = true, .guarantees = "symmetric positive definite M", .warm_start = true};

template <int kSolver>
struct SiconosSettings {
  static constexpr int solver = kSolver;
  static constexpr bool newton = kSolver == SICONOS_LCP_NEWTON_FB_FBLSA;
  static constexpr bool pgs = kSolver == SICONOS_LCP_PGS;
  static constexpr Capabilities capabilities = newton ? kNewtonFb : pgs ? kPgs : kLemke;

  double tolerance = newton ? 1e-10 : 1e-6;
  std::int64_t max_iterations = newton ? 1000 : 10000;

  void visit(auto&& field) {
    field("tolerance", tolerance, RealRange{.min = 0.0, .max = 1.0},
          newton ? "on |min(z, w)| / |q| after each step; 1e-10 is Siconos's default"
          : pgs  ? "on |min(z, w)| / |q| after each sweep; 1e-6 is Siconos's default"
                 : "on |min(z, w)| / |q| of the answer; 1e-6 is Siconos's default");
    field("max_iterations", max_iterations, IntegerRange{.min = 1, .max = 1000000000},
          newton ? "Newton steps at most; 1000 is Siconos's default"
          : pgs  ? "sweeps at most; 10000 is Siconos's default"
                 : "pivots at most; 10000 is Siconos's default");
  }
};

template <class Settings>
class SiconosSolver;

#ifndef LCPBENCH_DESCRIBE_ONLY

template <class Settings>
class SiconosSolver final : public MatrixAdapter<Settings> {
 public:
  using MatrixAdapter<Settings>::MatrixAdapter;

 private:
  void call(const SolveRequest& request, Answer& answer) override {
    const Settings& settings = this->settings_;
    if (request.start != nullptr && Settings::capabilities.warm_start) answer.z = *request.start;
    // The interface takes pointers that are not to const, and some solvers work in place: copies.
    Matrix M = this->lcp_.M;
    Vector q = this->lcp_.q;
    Vector w = Vector::Zero(q.size());
    const auto view = siconos_view(M);
    LinearComplementarityProblem problem{static_cast<int>(q.size()), view.get(), q.data()};
    const auto options = siconos_options(Settings::solver, settings.tolerance, settings.max_iterations);
    const int info = linearComplementarity_driver(&problem, answer.z.data(), w.data(), options.get());
    answer.counters.iterations = options->iparam[SICONOS_IPARAM_ITER_DONE];
    answer.claim = siconos_claim(info, answer.counters.iterations, settings.max_iterations);
    if (info != 0) answer.detail = "Siconos info " + std::to_string(info);
  }
};

#endif

template <class Settings>
SolverDefinition define_siconos(SolverDefinition definition) {
  return define_adapter<SiconosSolver<Settings>, Settings>(std::move(definition));
}

}  // namespace

SolverDefinition lcpbench_solver_siconos_lemke() {
  return define_siconos<SiconosSettings<SICONOS_LCP_LEMKE>>(
      {.name = "siconos_lemke",
       .summary = "Siconos's Lemke algorithm with lexicographic ordering on (q, M)",
       .source = "Siconos, numerics/src/LCP/lcp_lexicolemke.c; after Cottle, Pang, Stone 1992"});
}

SolverDefinition lcpbench_solver_siconos_newton_fb() {
  return define_siconos<SiconosSettings<SICONOS_LCP_NEWTON_FB_FBLSA>>(
      {.name = "siconos_newton_fb",
       .summary = "Siconos's Newton method on the Fischer-Burmeister function with a line search",
       .source = "Siconos, numerics/src/LCP; after De Luca, Facchinei, Kanzow 1996, Math. Program. 75"});
}

SolverDefinition lcpbench_solver_siconos_pgs() {
  return define_siconos<SiconosSettings<SICONOS_LCP_PGS>>(
      {.name = "siconos_pgs",
       .summary = "Siconos's projected Gauss-Seidel method (frictionless problems)",
       .source = "Siconos, numerics/src/LCP/lcp_pgs.c; after Cottle, Pang, Stone 1992"});
}

}  // namespace lcpbench
