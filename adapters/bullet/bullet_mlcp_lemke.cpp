// Bullet's btLemkeSolver: the wrapper that its worlds use around btLemkeAlgorithm.
//
// By default the library inverts M by elimination without pivoting. It then solves an LCP of order 2n, which has the
// bounds in its data. If the answer has an entry beyond 1e5, it returns zeros and reports a failure. The adapter
// changes none of this.
#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <BulletDynamics/MLCPSolvers/btLemkeSolver.h>

#include "adapters/bullet/bullet_common.h"
#endif

namespace lcpbench {
namespace {

constexpr Capabilities kBulletMlcpLemkeCapabilities{.guarantees = "none stated by the library"};

struct BulletMlcpLemkeSettings {
  std::int64_t max_loops = 1000;
  bool box = true;
  double upper = 1e10;
  double max_value = 1e5;

  void visit(auto&& field) {
    field("max_loops", max_loops, IntegerRange{.min = 1, .max = 1000000000}, "m_maxLoops: pivots at most");
    field("box", box, "m_useLoHighBounds: bounds in the data, with an inverse of M; false: btLemkeAlgorithm on (q, M)");
    field("upper", upper, RealRange{.min = 0.0}, "upper bound of every unknown, with box; 1e10 is that of contacts");
    field("max_value", max_value, RealRange{.min = 0.0}, "m_maxValue: an answer with a larger entry is discarded");
  }
};

class BulletMlcpLemke;

#ifndef LCPBENCH_DESCRIBE_ONLY

class BulletMlcpLemke final : public Solver {
 public:
  explicit BulletMlcpLemke(const BulletMlcpLemkeSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override { return kBulletMlcpLemkeCapabilities; }

 protected:
  void on_load(const Problem& problem) override { mlcp_.load(make_lcp(problem), settings_.upper); }

  void on_solve(const SolveRequest&, Answer& answer) override {
    btLemkeSolver solver;
    solver.m_maxLoops = static_cast<int>(settings_.max_loops);
    solver.m_useLoHighBounds = settings_.box;
    solver.m_maxValue = settings_.max_value;
    constexpr int kUnused = 0;  // btLemkeSolver ignores the number of iterations of the interface and reads m_maxLoops
    const bool solved = mlcp_.solve(solver, kUnused, answer.z);
    answer.claim = solved ? Claim::kSolved : Claim::kNumericalFailure;
    if (!solved) answer.detail = "solveMLCP returned false";
  }

 private:
  BulletMlcpLemkeSettings settings_;
  BulletMlcp mlcp_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_bullet_mlcp_lemke() {
  return define_adapter<BulletMlcpLemke, BulletMlcpLemkeSettings>(
      {.name = "bullet_mlcp_lemke",
       .summary = "Bullet's btLemkeSolver (float64): its Lemke algorithm as its worlds call it",
       .source = "Bullet Physics, BulletDynamics/MLCPSolvers; after J. E. Lloyd, ICRA 2005",
       .capabilities = kBulletMlcpLemkeCapabilities});
}

}  // namespace lcpbench
