// Siconos's solvers of contacts with the round friction cone, fc3d_driver: the reference for the error of the pyramid.
#include "adapters/round_cone.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <cstdio>

extern "C" {
#include <FrictionContactProblem.h>
#include <Friction_cst.h>
}

#include "adapters/siconos/siconos_common.h"
#endif

namespace lcpbench {
namespace {

enum class Fc3dMethod { kNsgs, kNsnAc, kAdmm };

struct SiconosFc3dSettings {
  static constexpr Capabilities capabilities{
      .frictionless_only = true,
      .friction_setting = "cone=true",
      .guarantees = "none; without friction, the method nsgs converges for symmetric positive definite M",
      .warm_start = true};

  bool cone = false;
  Fc3dMethod method = Fc3dMethod::kNsgs;
  double tolerance = 1e-10;
  std::int64_t max_iterations = 10000;

  void visit(auto&& field) {
    field("cone", cone, kConeHelp);
    field(
        "method", method,
        Choices<Fc3dMethod>{{{"nsgs", Fc3dMethod::kNsgs}, {"nsn_ac", Fc3dMethod::kNsnAc}, {"admm", Fc3dMethod::kAdmm}}},
        "nonsmooth Gauss-Seidel, the nonsmooth Newton method on Alart and Curnier's function, or ADMM");
    field("tolerance", tolerance, RealRange{.min = 0.0, .max = 1.0},
          "on Siconos's error, relative to |q|; Siconos's defaults: 1e-4 for nsgs, 1e-3 for nsn_ac, 1e-6 for admm");
    field("max_iterations", max_iterations, IntegerRange{.min = 1, .max = 1000000000},
          "sweeps or steps at most; Siconos's defaults: 1000, 200 and 20000");
  }
};

class SiconosFc3d;

#ifndef LCPBENCH_DESCRIBE_ONLY

class SiconosFc3d final : public RoundConeAdapter<SiconosFc3dSettings> {
 public:
  using RoundConeAdapter::RoundConeAdapter;

 private:
  std::string take(const Problem& problem) override {
    std::string refusal = cones_.load(problem, RoundCones::Frictionless::kThreeRows);
    return refusal.empty() && settings_.method == Fc3dMethod::kNsgs ? why_not_nsgs() : refusal;
  }

  /// An assertion of Siconos ends the process at such a contact. @returns "" where there is none
  std::string why_not_nsgs() const {
    for (Index i = 0; i < cones_.contacts(); ++i) {
      const Index row = cones_.normal_row(i);
      if (cones_.W()(row, row) > 0) continue;
      return "contact " + std::to_string(i) +
             ": its normal impulse does not raise its normal velocity (W_NN <= 0), by which nsgs divides; "
             "method=nsn_ac takes it";
    }
    return {};
  }

  void call(const SolveRequest& request, Answer& answer) override {
    // The interface takes pointers to data that may change.
    Matrix W = cones_.W();
    Vector q = cones_.q();
    Vector mu(cones_.contacts());
    for (Index i = 0; i < mu.size(); ++i) mu(i) = cones_.mu(i);
    Vector r = request.start != nullptr ? cones_.read(*request.start) : Vector::Zero(q.size());
    Vector u = Vector::Zero(q.size());
    const auto view = siconos_view(W);
    FrictionContactProblem problem{3, static_cast<int>(cones_.contacts()), view.get(), q.data(), mu.data()};
    const int method = settings_.method == Fc3dMethod::kNsgs    ? SICONOS_FRICTION_3D_NSGS
                       : settings_.method == Fc3dMethod::kNsnAc ? SICONOS_FRICTION_3D_NSN_AC
                                                                : SICONOS_FRICTION_3D_ADMM;
    const auto options = siconos_options(method, settings_.tolerance, settings_.max_iterations);
    const int info = fc3d_driver(&problem, r.data(), u.data(), options.get());
    answer.counters.iterations = options->iparam[SICONOS_IPARAM_ITER_DONE];
    answer.claim = siconos_claim(info, answer.counters.iterations, settings_.max_iterations);
    cones_.write(r, answer.z);
    answer.detail = detail(info, options->dparam[SICONOS_DPARAM_RESIDU]);
  }

  std::string detail(int info, double error) const {
    char text[160];
    std::snprintf(text, sizeof text, "%sSiconos info %d, error %.1e",
                  cones_.frictional() ? "another problem: the round friction cone; " : "", info, error);
    return text;
  }
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_siconos_fc3d() {
  return define_adapter<SiconosFc3d, SiconosFc3dSettings>(
      {.name = "siconos_fc3d",
       .summary = "Siconos's contact solvers (fc3d_driver), with the round friction cone if cone=true",
       .source =
           "Siconos, numerics/src/FrictionContact; Acary, Bremond, Huber 2018, Advanced Topics in Nonsmooth Dynamics"});
}

}  // namespace lcpbench
