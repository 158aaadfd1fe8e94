// Bullet's btSolveProjectedGaussSeidel on the matrix.
#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <BulletDynamics/MLCPSolvers/btSolveProjectedGaussSeidel.h>

#include "adapters/bullet/bullet_common.h"
#endif

namespace lcpbench {
namespace {

constexpr Capabilities kBulletPgsCapabilities{.frictionless_only = true,
                                     .guarantees = "converges for symmetric positive definite M",
                                     .warm_start = true};

struct BulletPgsSettings {
  std::int64_t iterations = 10;

  void visit(auto&& field) {
    field("iterations", iterations, IntegerRange{.min = 1, .max = 1000000000},
          "sweeps over the unknowns; 10 is Bullet's default for a step");
  }
};

class BulletPgs;

#ifndef LCPBENCH_DESCRIBE_ONLY

class BulletPgs final : public Solver {
 public:
  explicit BulletPgs(const BulletPgsSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override { return kBulletPgsCapabilities; }

 protected:
  void on_load(const Problem& problem) override { mlcp_.load(make_lcp(problem), static_cast<double>(BT_INFINITY)); }

  void on_solve(const SolveRequest& request, Answer& answer) override {
    if (request.start != nullptr) answer.z = *request.start;
    btSolveProjectedGaussSeidel solver;
    // It has no test of convergence that could fail: what it returns is always true.
    const bool solved = mlcp_.solve(solver, static_cast<int>(settings_.iterations), answer.z);
    answer.counters.iterations = settings_.iterations;
    answer.claim = solved ? Claim::kSolved : Claim::kNumericalFailure;
  }

 private:
  BulletPgsSettings settings_;
  BulletMlcp mlcp_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_bullet_pgs() {
  return define_adapter<BulletPgs, BulletPgsSettings>(
      {.name = "bullet_pgs",
       .summary = "Bullet's projected Gauss-Seidel solver (btSolveProjectedGaussSeidel, float64)",
       .source = "Bullet Physics, BulletDynamics/MLCPSolvers; finished sweeps count as a claim, it has no failure",
       .capabilities = kBulletPgsCapabilities});
}

}  // namespace lcpbench
