// ODE's Dantzig solver on the matrix, from the copy of it that DART has as a library: ODE itself does not export it.
#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <vector>

#include <dart/external/odelcpsolver/lcp.h>
static_assert(sizeof(dart::external::ode::dReal) == sizeof(double), "needs the solver in double precision");
#endif

namespace lcpbench {
namespace {

struct OdeDantzigSettings {
  static constexpr Capabilities capabilities{.frictionless_only = true, .guarantees = "symmetric positive definite M"};

  double diagonal = 0.0;

  void visit(auto&& field) {
    field("diagonal", diagonal, RealRange{.min = 0}, "added to the diagonal of M before solving");
  }
};

class OdeDantzig;

#ifndef LCPBENCH_DESCRIBE_ONLY

/// A x = b + w with b = -q and bounds 0 <= x < infinity. Rows of A are padded to multiples of four
/// numbers, but for a single one (dPAD).
class OdeDantzig final : public MatrixAdapter<OdeDantzigSettings> {
 public:
  using MatrixAdapter::MatrixAdapter;

 private:
  std::string take(const Problem& problem) override {
    MatrixAdapter::take(problem);
    lcp_.M.diagonal().array() += settings_.diagonal;
    padded_.setZero(dPAD(lcp_.size()), lcp_.size());
    // The library is row-major and reads its lower triangle: the upper one of our column-major M.
    padded_.topRows(lcp_.size()) = lcp_.M;
    return {};
  }

  void call(const SolveRequest&, Answer& answer) override {
    const int n = static_cast<int>(lcp_.size());
    // The library works in place on all of its input.
    destroyed_ = padded_;
    b_ = -lcp_.q;
    w_.setZero(n);
    lower_.setZero(n);
    upper_.setConstant(n, static_cast<double>(dInfinity));
    no_friction_.assign(static_cast<std::size_t>(n), -1);
    constexpr int kUnbounded = 0;
    constexpr bool kEarlyTermination = true;  // without it the return value is always true
    const bool solved =
        dart::external::ode::dSolveLCP(n, destroyed_.data(), answer.z.data(), b_.data(), w_.data(), kUnbounded,
                                       lower_.data(), upper_.data(), no_friction_.data(), kEarlyTermination);
    answer.claim = solved ? Claim::kSolved : Claim::kNumericalFailure;
    if (!solved) answer.detail = "dSolveLCP returned false";
  }

  Matrix padded_, destroyed_;
  Vector b_, w_, lower_, upper_;
  std::vector<int> no_friction_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_ode_dantzig() {
  return define_adapter<OdeDantzig, OdeDantzigSettings>(
      {.name = "ode_dantzig",
       .summary = "ODE's Dantzig solver (dSolveLCP): principal pivoting, as in dWorldStep",
       .source = "Open Dynamics Engine, lcp.cpp, in DART's copy; after Baraff, SIGGRAPH 1994"});
}

}  // namespace lcpbench
