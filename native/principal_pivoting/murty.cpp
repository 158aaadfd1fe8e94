#include <algorithm>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/answer_test/answer_test.h"
#include "native/principal_pivoting/principal_tableau.h"

namespace lcpbench {
namespace {

struct MurtySettings {
  std::int64_t max_pivots = 0;
  double data_error = 1e-14;
  double accept_residual = 1e-6;

  void visit(auto&& field) {
    field("max_pivots", max_pivots, IntegerRange{.min = 0}, "0 stands for max(1000, n^2), the paper's limit");
    field("data_error", data_error, RealRange{.min = 0, .max = 1},
          "relative error of M and q: values that errors of this size could make 0 count as 0");
    field(
        "accept_residual", accept_residual, RealRange{.min = 0},
        "asked for before the test of every claim: max|min(c_i z_i, w_i)| <= this * max|q|, c_i the largest |entry| of "
        "M's column i");
  }
};

/// Murty's least-index Bard-type scheme: exchange z_i and w_i of the smallest i whose basic variable is negative.
///
/// Finite for P-matrices, whatever q, in at most 2^n - 1 pivots; elsewhere it may meet a zero pivot or cycle (then the
/// limit ends it), and it never proves that there is no solution. "Negative" means beyond what errors of the data
/// explain. O(n^2) per pivot. [Murty 1974; Cottle, Pang, Stone 1992, section 4.2]
class Murty final : public Solver {
 public:
  explicit Murty(const MurtySettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override;

 protected:
  void on_load(const Problem& problem) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

 private:
  enum class End { kNonnegative, kZeroPivot, kSingularBasis, kPivotLimit, kTimeLimit };
  End run(double deadline_s, Counters& counters);
  Index least_negative();
  bool has_pivot(Index i);
  bool rebuild(Counters& counters);

  MurtySettings settings_;
  PrincipalTableau tableau_;
  AnswerTest test_;
  Vector bounds_;  // n
};

void Murty::on_load(const Problem& problem) {
  tableau_.load(make_lcp(problem));
  test_.load(problem);
  bounds_.resize(tableau_.size());
}

/// -1: none.
Index Murty::least_negative() {
  const Index n = tableau_.size();
  tableau_.constant_errors(settings_.data_error, bounds_);
  for (Index i = 0; i < n; ++i) {
    if (!(tableau_.constants()(i) >= -bounds_(i))) return i;
  }
  return -1;
}

/// The diagonal entry of a basic z belongs to an inverse: nothing makes it 0.
bool Murty::has_pivot(Index i) {
  if (tableau_.z_is_basic(i)) return tableau_.matrix()(i, i) > 0;
  tableau_.column_errors(i, settings_.data_error, bounds_);
  return tableau_.matrix()(i, i) > bounds_(i);
}

bool Murty::rebuild(Counters& counters) {
  ++counters.factorizations;
  return tableau_.rebuild();
}

Murty::End Murty::run(double deadline_s, Counters& counters) {
  const Index n = tableau_.size();
  const std::int64_t limit = settings_.max_pivots > 0 ? settings_.max_pivots : std::max<std::int64_t>(1000, n * n);
  tableau_.reset();
  for (;;) {
    if (!(wall_clock_s() < deadline_s)) return End::kTimeLimit;
    const Index i = least_negative();
    const bool can_go_on = i >= 0 && has_pivot(i);
    // An end counts only in a tableau without the errors of the way; rebuilding after n pivots keeps O(n^2) each.
    if (tableau_.pivots_since_rebuild() > (can_go_on ? n : 0)) {
      if (!rebuild(counters)) return End::kSingularBasis;
      continue;
    }
    if (i < 0) return End::kNonnegative;
    if (!can_go_on) return End::kZeroPivot;
    if (counters.pivots >= limit) return End::kPivotLimit;
    tableau_.pivot(i);
    ++counters.pivots;
  }
}

void Murty::on_solve(const SolveRequest& request, Answer& answer) {
  answer.counters = {.iterations = -1, .pivots = 0, .factorizations = 0};
  const double deadline_s = wall_clock_s() + request.time_limit_s;
  const End end = run(deadline_s, answer.counters);
  tableau_.solution(answer.z);
  switch (end) {
    case End::kNonnegative:
      if (tableau_.residual(answer.z) <= settings_.accept_residual * tableau_.largest_q()) {
        answer.claim = Claim::kSolved;
        test_.settle(answer, deadline_s);
      } else {
        answer.detail = "the final basis is too ill-conditioned for the accuracy asked for";
      }
      return;
    case End::kZeroPivot: answer.detail = "zero pivot: M is no P-matrix to working precision"; return;
    case End::kSingularBasis: answer.detail = "the basis is singular to working precision"; return;
    case End::kPivotLimit: answer.claim = Claim::kIterationLimit; return;
    case End::kTimeLimit: answer.claim = Claim::kTimeLimit; return;
  }
}

constexpr Capabilities kCapabilities{.guarantees = "P-matrices", .obeys_time_limit = true, .allocation_free = true};

const Capabilities& Murty::capabilities() const { return kCapabilities; }

}  // namespace

SolverDefinition lcpbench_solver_murty() {
  return define_solver<Murty, MurtySettings>(
      {.name = "murty",
       .summary = "least-index principal pivoting (Bard type), for P-matrices",
       .source = "Murty 1974: Note on a Bard-type scheme for solving the complementarity problem; Cottle, Pang, Stone "
                 "1992, section 4.2",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
