// Simbody's impulse solvers on a problem, without a Simbody system: PGSImpulseSolver, projected Gauss-Seidel
// over-relaxed by 1.2, and PLUSImpulseSolver (Poisson, Lankarani, Uchida, Sherman), Newton steps on a guessed set of
// active rows.
#include "adapters/round_cone.h"
#include "adapters/simbody/impulse_solver.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <exception>
#include <vector>
#endif

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
  simbody::Request request() const { return {simbody::Method::kPgs, tolerance, static_cast<int>(max_iterations), 0.0}; }
};

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
  simbody::Request request() const {
    return {simbody::Method::kPlus, tolerance, static_cast<int>(max_iterations), slip_speed};
  }
};

template <class Settings>
class SimbodySolver;

#ifndef LCPBENCH_DESCRIBE_ONLY

template <class Settings>
class SimbodySolver final : public RoundConeAdapter<Settings> {
 public:
  using RoundConeAdapter<Settings>::RoundConeAdapter;

 private:
  using RoundConeAdapter<Settings>::cones_;

  std::string take(const Problem& problem) override {
    std::string refusal = cones_.load(problem, RoundCones::Frictionless::kOneRow);
    if (!refusal.empty()) return refusal;
    contacts_.clear();
    for (Index i = 0; i < cones_.contacts(); ++i) {
      contacts_.push_back({static_cast<int>(cones_.normal_row(i)), cones_.has_tangents(i), cones_.mu(i)});
    }
    r_.resize(cones_.q().size());
    return {};
  }

  void call(const SolveRequest&, Answer& answer) override {
    try {
      const bool solved = simbody::solve(this->settings_.request(), contacts_, static_cast<int>(r_.size()),
                                         cones_.W().data(), cones_.q().data(), r_.data());
      answer.claim = solved ? Claim::kSolved : Claim::kNumericalFailure;
    } catch (const std::exception& error) {
      answer.detail = error.what();
      return;
    }
    cones_.write(r_, answer.z);
    if (cones_.frictional()) {
      answer.detail = "another problem: the round friction cone";
    } else if (answer.claim != Claim::kSolved) {
      answer.detail = "solve returned false";
    }
  }

  std::vector<simbody::Contact> contacts_;
  Vector r_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_simbody_pgs() {
  return define_adapter<SimbodySolver<SimbodyPgsSettings>, SimbodyPgsSettings>(
      {.name = "simbody_pgs",
       .summary = "Simbody's PGSImpulseSolver, with the round friction cone if cone=true",
       .source = "Simbody, simbody/internal/PGSImpulseSolver.h; Sherman, Seth, Delp 2011, Procedia IUTAM 2"});
}

SolverDefinition lcpbench_solver_simbody_plus() {
  return define_adapter<SimbodySolver<SimbodyPlusSettings>, SimbodyPlusSettings>(
      {.name = "simbody_plus",
       .summary = "Simbody's PLUSImpulseSolver, with the round friction cone if cone=true",
       .source = "Simbody, simbody/internal/PLUSImpulseSolver.h; Uchida, Sherman, Delp 2015, Proc. R. Soc. A 471"});
}

}  // namespace lcpbench
