// Bullet's Lemke algorithm and its projected Gauss-Seidel solver, both on the matrix. Its Dantzig solver is in
// bullet_dantzig.cpp.
#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <BulletDynamics/MLCPSolvers/btLemkeAlgorithm.h>
#include <BulletDynamics/MLCPSolvers/btSolveProjectedGaussSeidel.h>
static_assert(sizeof(btScalar) == sizeof(double), "needs Bullet's float64 build");
#endif

namespace lcpbench {
namespace {

struct BulletLemkeSettings {
  static constexpr Capabilities capabilities{.guarantees = "none stated by the library"};

  std::int64_t max_loops = 1000;

  void visit(auto&& field) {
    field("max_loops", max_loops, IntegerRange{.min = 1, .max = 1000000000},
          "pivots at most; btLemkeAlgorithm's own default is 100, 1000 is that of btLemkeSolver around it");
  }
};

struct BulletPgsSettings {
  static constexpr Capabilities capabilities{
      .frictionless_only = true, .guarantees = "converges for symmetric positive definite M", .warm_start = true};

  std::int64_t iterations = 10;

  void visit(auto&& field) {
    field("iterations", iterations, IntegerRange{.min = 1, .max = 1000000000},
          "sweeps over the unknowns; 10 is Bullet's default for a step");
  }
};

class BulletLemke;
class BulletPgs;

#ifndef LCPBENCH_DESCRIBE_ONLY

btMatrixXu matrix_of(const Matrix& M) {
  const int n = static_cast<int>(M.rows());
  btMatrixXu result(n, n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) result.setElem(i, j, M(i, j));
  }
  return result;
}

btVectorXu vector_of(const Vector& values) {
  btVectorXu result(static_cast<int>(values.size()));
  for (int i = 0; i < result.rows(); ++i) result[i] = values(i);
  return result;
}

/// btLemkeAlgorithm, the class itself.
class BulletLemke final : public Adapter<BulletLemkeSettings> {
 public:
  using Adapter::Adapter;

 private:
  std::string take(const Problem& problem) override {
    const Lcp lcp = finite_lcp(problem);
    M_ = matrix_of(lcp.M);
    q_ = vector_of(lcp.q);
    return {};
  }

  void call(const SolveRequest&, Answer& answer) override {
    const int n = q_.rows();
    btLemkeAlgorithm lemke(M_, q_);
    const btVectorXu wz = lemke.solve(static_cast<unsigned>(settings_.max_loops));
    answer.counters.pivots = lemke.getSteps();
    if (wz.rows() < 2 * n) {
      answer.detail = "returned " + std::to_string(wz.rows()) + " numbers instead of 2 n";
      return;
    }
    for (int i = 0; i < n; ++i) answer.z(i) = wz[n + i];  // the first half is w
    if (lemke.getInfo() == 0) {
      answer.claim = Claim::kSolved;
      if (!answer.z.isZero(0)) answer.counters.pivots += 2;  // the steps leave out the last two
    } else if (answer.counters.pivots >= settings_.max_loops) {
      answer.claim = Claim::kIterationLimit;
    } else {
      answer.detail = "getInfo() = " + std::to_string(lemke.getInfo());
    }
  }

  btMatrixXu M_;
  btVectorXu q_;
};

/// An LCP in the form of Bullet's solvers of boxed problems: A x = b + w with A = M, b = -q and 0 <= x <= upper. In
/// this form a bound may depend on another unknown, as that of friction does; here none does.
class BulletMlcp {
 public:
  void load(const Lcp& lcp, double upper) {
    A_ = matrix_of(lcp.M);
    b_ = vector_of(-lcp.q);
    lower_ = vector_of(Vector::Zero(lcp.size()));
    upper_ = vector_of(Vector::Constant(lcp.size(), upper));
    limit_dependency_.resize(0);
    for (int i = 0; i < b_.rows(); ++i) limit_dependency_.push_back(-1);  // on no other unknown
  }

  /// @param z  n: the start on entry, x on return
  /// @returns what the solver returns: its claim
  bool solve(btMLCPSolverInterface& solver, int iterations, Vector& z) {
    btVectorXu x = vector_of(z);
    const bool claim = solver.solveMLCP(A_, b_, x, lower_, upper_, limit_dependency_, iterations);
    for (int i = 0; i < x.rows(); ++i) z(i) = x[i];
    return claim;
  }

 private:
  btMatrixXu A_;
  btVectorXu b_, lower_, upper_;
  btAlignedObjectArray<int> limit_dependency_;
};

class BulletPgs final : public Adapter<BulletPgsSettings> {
 public:
  using Adapter::Adapter;

 private:
  std::string take(const Problem& problem) override {
    mlcp_.load(finite_lcp(problem), static_cast<double>(BT_INFINITY));
    return {};
  }

  void call(const SolveRequest& request, Answer& answer) override {
    if (request.start != nullptr) answer.z = *request.start;
    btSolveProjectedGaussSeidel solver;
    // It has no test of convergence that could fail: what it returns is always true.
    const bool solved = mlcp_.solve(solver, static_cast<int>(settings_.iterations), answer.z);
    answer.counters.iterations = settings_.iterations;
    answer.claim = solved ? Claim::kSolved : Claim::kNumericalFailure;
  }

  BulletMlcp mlcp_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_bullet_lemke() {
  return define_adapter<BulletLemke, BulletLemkeSettings>(
      {.name = "bullet_lemke",
       .summary = "Bullet's Lemke algorithm (btLemkeAlgorithm) on (q, M)",
       .source = "Bullet Physics, BulletDynamics/MLCPSolvers; after J. E. Lloyd, ICRA 2005"});
}

SolverDefinition lcpbench_solver_bullet_pgs() {
  return define_adapter<BulletPgs, BulletPgsSettings>(
      {.name = "bullet_pgs",
       .summary = "Bullet's projected Gauss-Seidel solver (btSolveProjectedGaussSeidel, float64)",
       .source = "Bullet Physics, BulletDynamics/MLCPSolvers; finished sweeps count as a claim, it has no failure"});
}

}  // namespace lcpbench
