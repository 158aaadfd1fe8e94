#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/principal_pivoting/principal_solver.h"

namespace lcpbench {
namespace {

constexpr Capabilities kCapabilities{.guarantees = "P-matrices", .obeys_time_limit = true, .allocation_free = true};

/// Murty's least-index Bard-type scheme: exchange z_i and w_i of the smallest i whose basic variable is negative.
///
/// Finite for P-matrices, whatever q, in at most 2^n - 1 pivots. Elsewhere it may end at a pivot that is not positive,
/// or cycle until the limit; it never proves that there is no solution. "Negative" means beyond what errors of the data
/// explain. O(n^2) per pivot. [Murty 1974; Cottle, Pang, Stone 1992, section 4.2]
class Murty final : public PrincipalSolver {
 public:
  explicit Murty(const PrincipalSettings& settings)
      : PrincipalSolver(settings, "no positive pivot: M is no P-matrix to working precision") {}
  const Capabilities& capabilities() const override { return kCapabilities; }

 private:
  End run(double deadline_s, Counters& counters) override;
  Index first_negative();
};

/// The smallest i whose basic variable is negative or NaN; -1: none. Writes the error bounds of the constants. O(n^2)
Index Murty::first_negative() {
  const Index n = tableau_.size();
  tableau_.constant_errors(data_error_, bounds_);
  for (Index i = 0; i < n; ++i) {
    if (!(tableau_.constants()(i) >= -bounds_(i))) return i;
  }
  return -1;
}

Murty::End Murty::run(double deadline_s, Counters& counters) {
  const Index n = tableau_.size();
  tableau_.reset();
  for (;;) {
    if (!(wall_clock_s() < deadline_s)) return End::kTimeLimit;
    const Index i = first_negative();
    const bool can_go_on = i >= 0 && has_pivot(i, bounds_);
    // An end other than a limit counts only in a tableau without rounding errors of earlier pivots. Rebuilding it after
    // more than n pivots costs O(n^2) for each of them.
    if (tableau_.pivots_since_rebuild() > (can_go_on ? n : 0)) {
      if (!rebuild_tableau(counters)) return End::kSingularBasis;
      continue;
    }
    if (i < 0) return End::kNonnegative;
    if (!can_go_on) return End::kNoPivot;
    if (counters.pivots >= pivot_limit_) return End::kPivotLimit;
    tableau_.pivot(i);
    ++counters.pivots;
  }
}

}  // namespace

SolverDefinition lcpbench_solver_murty() {
  return define_solver<Murty, PrincipalSettings>(
      {.name = "murty",
       .summary = "least-index principal pivoting (Bard type), for P-matrices",
       .source = "Murty 1974: Note on a Bard-type scheme for solving the complementarity problem; Cottle, Pang, Stone "
                 "1992, section 4.2",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
