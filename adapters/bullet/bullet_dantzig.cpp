#include <vector>

#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <BulletDynamics/MLCPSolvers/btDantzigLCP.h>
#endif

namespace lcpbench {
namespace {

struct BulletDantzigSettings {
  static constexpr Capabilities capabilities{.frictionless_only = true, .guarantees = "symmetric positive definite M"};

  double diagonal = 0.0;

  void visit(auto&& field) {
    field("diagonal", diagonal, RealRange{.min = 0}, "added to the diagonal of M before solving");
  }
};

class BulletDantzig;

#ifndef LCPBENCH_DESCRIBE_ONLY

static_assert(sizeof(btScalar) == sizeof(double), "needs Bullet's float64 build");

/// Bullet's Dantzig solver on the dense matrix: A x = b + w with b = -q, bounds 0 <= x < infinity, no friction index.
class BulletDantzig final : public MatrixAdapter<BulletDantzigSettings> {
 public:
  using MatrixAdapter::MatrixAdapter;

 private:
  std::string take(const Problem& problem) override {
    MatrixAdapter::take(problem);
    lcp_.M.diagonal().array() += settings_.diagonal;
    slack_.setZero(lcp_.size());
    lower_.setZero(lcp_.size());
    upper_.setConstant(lcp_.size(), static_cast<double>(BT_INFINITY));
    friction_index_.assign(static_cast<std::size_t>(lcp_.size()), -1);
    return {};
  }

  void call(const SolveRequest&, Answer& answer) override {
    // The library overwrites M and b, and permutes the bounds and friction indices, whose entries are all equal. It
    // reads one triangle: of our columns, which are its rows, the upper.
    destroyed_M_ = lcp_.M;
    b_ = -lcp_.q;
    const bool solved =
        btSolveDantzigLCP(static_cast<int>(lcp_.size()), destroyed_M_.data(), answer.z.data(), b_.data(), slack_.data(),
                          0, lower_.data(), upper_.data(), friction_index_.data(), scratch_);
    answer.claim = solved ? Claim::kSolved : Claim::kNumericalFailure;
    if (!solved) answer.detail = "btSolveDantzigLCP returned false";
  }

  Matrix destroyed_M_;
  Vector b_, slack_, lower_, upper_;
  std::vector<int> friction_index_;
  btDantzigScratchMemory scratch_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_bullet_dantzig() {
  return define_adapter<BulletDantzig, BulletDantzigSettings>(
      {.name = "bullet_dantzig",
       .summary =
           "Bullet's Dantzig solver (btSolveDantzigLCP, float64): principal pivoting, as its MLCP constraint solver",
       .source = "Bullet Physics, BulletDynamics/MLCPSolvers/btDantzigLCP; after Baraff, SIGGRAPH 1994"});
}

}  // namespace lcpbench
