#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <BulletDynamics/MLCPSolvers/btDantzigLCP.h>
#endif

namespace lcpbench {
namespace {

struct BulletDantzigSettings {
  static constexpr Capabilities capabilities{
      .frictionless_only = true, .boxed = true, .guarantees = "symmetric positive definite M, no rows of friction"};

  double diagonal = 0.0;

  void visit(auto&& field) {
    field("diagonal", diagonal, RealRange{.min = 0}, "added to the diagonal of M before solving");
  }
};

class BulletDantzig;

#ifndef LCPBENCH_DESCRIBE_ONLY

static_assert(sizeof(btScalar) == sizeof(double), "needs Bullet's float64 build");

/// Bullet's Dantzig solver on the dense matrix: A x = b + w with b = -q. The bounds of a mixed LCP are its own; it
/// fixes those of friction by a solve without friction, which is another problem.
class BulletDantzig final : public MatrixAdapter<BulletDantzigSettings> {
 public:
  using MatrixAdapter::MatrixAdapter;

 private:
  std::string take(const Problem& problem) override {
    MatrixAdapter::take(problem);
    lcp_.M.diagonal().array() += settings_.diagonal;
    slack_.setZero(lcp_.size());
    bounds_ = library_bounds(lcp_, static_cast<double>(BT_INFINITY));
    return why_not_around_zero(lcp_.bounds);
  }

  void call(const SolveRequest&, Answer& answer) override {
    // The library overwrites M and b, and permutes the bounds and friction indices. It reads one triangle: of our
    // columns, which are its rows, the upper.
    destroyed_M_ = lcp_.M;
    destroyed_ = bounds_;
    b_ = -lcp_.q;
    const bool solved =
        btSolveDantzigLCP(static_cast<int>(lcp_.size()), destroyed_M_.data(), answer.z.data(), b_.data(), slack_.data(),
                          0, destroyed_.lower.data(), destroyed_.upper.data(), destroyed_.friction_of.data(), scratch_);
    answer.claim = solved ? Claim::kSolved : Claim::kNumericalFailure;
    if (!solved) answer.detail = "btSolveDantzigLCP returned false";
  }

  Matrix destroyed_M_;
  Vector b_, slack_;
  LcpBounds bounds_, destroyed_;
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
