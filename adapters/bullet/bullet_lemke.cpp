// Bullet's btLemkeAlgorithm on the matrix: the class itself, not the btLemkeSolver wrapper around it.
#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <BulletDynamics/MLCPSolvers/btLemkeAlgorithm.h>
static_assert(sizeof(btScalar) == sizeof(double), "this adapter is for Bullet's float64 build");
#endif

namespace lcpbench {
namespace {

constexpr Capabilities kBulletLemkeCapabilities{.guarantees = "none stated by the library"};

struct BulletLemkeSettings {
  std::int64_t max_loops = 1000;

  void visit(auto&& field) {
    field("max_loops", max_loops, IntegerRange{.min = 1, .max = 1000000000},
          "pivots at most; btLemkeAlgorithm's own default is 100, 1000 is that of btLemkeSolver around it");
  }
};

class BulletLemke;

#ifndef LCPBENCH_DESCRIBE_ONLY

class BulletLemke final : public Solver {
 public:
  explicit BulletLemke(const BulletLemkeSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override { return kBulletLemkeCapabilities; }

 protected:
  void on_load(const Problem& problem) override {
    const Lcp lcp = make_lcp(problem);
    const int n = static_cast<int>(lcp.size());
    M_.resize(n, n);
    q_.resize(n);
    for (int i = 0; i < n; ++i) {
      q_[i] = lcp.q(i);
      for (int j = 0; j < n; ++j) M_.setElem(i, j, lcp.M(i, j));
    }
  }

  void on_solve(const SolveRequest&, Answer& answer) override {
    const int n = q_.rows();
    if (n == 0) {
      answer.claim = Claim::kSolved;
      return;
    }
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
    } else if (answer.counters.pivots >= settings_.max_loops) {
      answer.claim = Claim::kIterationLimit;
    } else {
      answer.detail = "getInfo() = " + std::to_string(lemke.getInfo());
    }
  }

 private:
  BulletLemkeSettings settings_;
  btMatrixXu M_;
  btVectorXu q_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_bullet_lemke() {
  return define_adapter<BulletLemke, BulletLemkeSettings>(
      {.name = "bullet_lemke",
       .summary = "Bullet's Lemke algorithm (btLemkeAlgorithm) on (q, M)",
       .source = "Bullet Physics, BulletDynamics/MLCPSolvers; after J. E. Lloyd, ICRA 2005",
       .capabilities = kBulletLemkeCapabilities});
}

}  // namespace lcpbench
