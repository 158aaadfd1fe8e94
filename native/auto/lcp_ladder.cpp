#include "native/auto/lcp_ladder.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/quad.h"
#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench {

SolverDefinition lcpbench_solver_lemke();
SolverDefinition lcpbench_solver_principal_pivoting();
SolverDefinition lcpbench_solver_regularized();

namespace {

constexpr double kClaimedError = 5e-10;
/// How finely a proof has to hold: as well as doubles can tell, or as well as 113 bits can, in which their products are
/// exact.
constexpr Quad kDouble = 4e-16;
constexpr Quad kExact = 4 * kQuadUnitRoundoff;
/// Loading these takes O(n^2); `regularized`, the last, allocates in any case.
constexpr std::size_t kLoadedAtOnce = 3;

Options with_limit(Options options, std::int64_t max_pivots) {
  if (max_pivots > 0) options.emplace_back("max_pivots", std::to_string(max_pivots));
  return options;
}

}  // namespace

void LcpLadder::make_rungs() {
  const Options tight{{"pivot_tolerance", "1e-13"}, {"zero_tolerance", "1e-14"}};
  rungs_.push_back({"lemke, double", lcpbench_solver_lemke().make(with_limit(tight, max_pivots_)), false});
  rungs_.push_back({"lemke, loose", lcpbench_solver_lemke().make(with_limit({}, max_pivots_)), false});
  rungs_.push_back(
      {"principal_pivoting", lcpbench_solver_principal_pivoting().make(with_limit({}, max_pivots_)), false});
  rungs_.push_back({"regularized", lcpbench_solver_regularized().make({}), false});
}

void LcpLadder::load(const Problem& problem) {
  if (rungs_.empty()) make_rungs();
  problem_ = problem;
  const Lcp& lcp = problem_.lcp();
  row_norm_ = lcp.M.cwiseAbs().rowwise().sum();
  w_.resize(lcp.size());
  attempt_.z.resize(lcp.size());
  for (std::size_t k = 0; k < rungs_.size(); ++k) {
    rungs_[k].loaded = k < kLoadedAtOnce;
    if (rungs_[k].loaded) rungs_[k].solver->load(problem_);
  }
}

void LcpLadder::solve(const SolveRequest& request, Answer& answer, const char*& text) {
  const double deadline_s =
      std::isinf(request.time_limit_s) ? request.time_limit_s : wall_clock_s() + request.time_limit_s;
  answer.counters = {.iterations = 0, .pivots = 0, .factorizations = 0};
  text = "no answer passed the test";
  for (Rung& rung : rungs_) {
    const bool first = &rung == &rungs_.front();
    SolveRequest inner = request;
    inner.start = nullptr;
    if (!std::isinf(deadline_s) && !first) inner.time_limit_s = deadline_s - wall_clock_s();
    if (!(inner.time_limit_s > 0)) {
      answer.claim = Claim::kTimeLimit;
      return;
    }
    if (!rung.loaded) rung.solver->load(problem_);
    rung.loaded = true;
    rung.solver->solve(inner, attempt_);
    answer.counters.iterations += std::max<std::int64_t>(attempt_.counters.iterations, 0);
    answer.counters.pivots += std::max<std::int64_t>(attempt_.counters.pivots, 0);
    answer.counters.factorizations += std::max<std::int64_t>(attempt_.counters.factorizations, 0);
    if (attempt_.claim == Claim::kSolved && solves(attempt_.z)) {
      Vector farkas = witness(attempt_.z);
      if (proves(farkas, kExact)) return report_unsolvable(farkas, answer, text);
      answer.claim = Claim::kSolved;
      answer.z.swap(attempt_.z);
      text = rung.name;
      return;
    }
    if (attempt_.claim == Claim::kUnsolvable && proves(attempt_.farkas, kDouble)) {
      return report_unsolvable(attempt_.farkas, answer, text);
    }
    // All methods share the limit: what one has used up, the next would exceed.
    if (max_pivots_ > 0 && answer.counters.pivots >= max_pivots_) {
      answer.claim = Claim::kIterationLimit;
      text = "pivot limit";
      return;
    }
    if (attempt_.claim == Claim::kTimeLimit) {
      answer.claim = Claim::kTimeLimit;
      return;
    }
  }
}

/// Also false for what is not a number.
bool LcpLadder::solves(const Vector& z) {
  const Lcp& lcp = problem_.lcp();
  if (z.size() != lcp.size()) return false;
  if (z.size() == 0) return true;
  if (!(z.minCoeff() >= 0) || !z.allFinite()) return false;
  w_ = lcp.q;
  w_.noalias() += lcp.M * z;
  const double largest = z.maxCoeff();
  for (Index i = 0; i < z.size(); ++i) {
    const double violation = z(i) > 0 ? std::abs(w_(i)) : std::max(0.0, -w_(i));
    const double scale = std::abs(lcp.q(i)) + row_norm_(i) * largest;
    if (!(violation <= kClaimedError * scale)) return false;
  }
  return true;
}

/// u >= 0, M'u <= 0 and q'u < 0, where n `unit` of the magnitudes of its terms counts as the rounding of a sum.
bool LcpLadder::proves(const Vector& farkas, Quad unit) const {
  const Lcp& lcp = problem_.lcp();
  if (farkas.size() != lcp.size() || farkas.size() == 0 || !farkas.allFinite() || !(farkas.minCoeff() >= 0)) {
    return false;
  }
  const Quad tolerance = unit * static_cast<Quad>(lcp.size());
  const auto sums = [&farkas](const auto& column) {
    std::pair<Quad, Quad> sum{0, 0};  // of the products, and of their magnitudes
    for (Index i = 0; i < farkas.size(); ++i) {
      const Quad product = static_cast<Quad>(column(i)) * static_cast<Quad>(farkas(i));
      sum.first += product;
      sum.second += abs(product);
    }
    return sum;
  };
  for (Index j = 0; j < farkas.size(); ++j) {
    const auto [sum, magnitude] = sums(lcp.M.col(j));
    if (!(sum <= tolerance * magnitude)) return false;
  }
  const auto [sum, magnitude] = sums(lcp.q);
  return sum < -tolerance * magnitude;
}

/// Of an answer that passes, where it violates w >= 0 by more than rounding: what would prove that nothing can do
/// without, 1 for the row that is worst and for the rows of the support what keeps their z out of the sum:
/// O(support^3), allocates. Else empty.
Vector LcpLadder::witness(const Vector& z) const {
  const Lcp& lcp = problem_.lcp();
  const double rounding = 0x1p-53 * static_cast<double>(lcp.size() + 1);
  Index worst = -1;
  double most = 0;
  for (Index i = 0; i < z.size(); ++i) {
    if (z(i) > 0) continue;
    const double excess = -w_(i) - rounding * (std::abs(lcp.q(i)) + lcp.M.row(i).cwiseAbs().dot(z));
    if (excess > most) {
      most = excess;
      worst = i;
    }
  }
  if (worst < 0) return {};
  std::vector<Index> support;
  for (Index i = 0; i < z.size(); ++i) {
    if (z(i) > 0) support.push_back(i);
  }
  Vector u = Vector::Zero(z.size());
  u(worst) = 1;
  if (support.empty()) return u;
  const Matrix block = lcp.M(support, support).transpose();
  const Vector weights = Eigen::PartialPivLU<Matrix>(block).solve(-lcp.M(worst, support).transpose());
  for (std::size_t k = 0; k < support.size(); ++k) u(support[k]) = weights(static_cast<Index>(k));
  return u;
}

/// As unsolvable, with its proof, which `farkas` is.
void LcpLadder::report_unsolvable(Vector& farkas, Answer& answer, const char*& text) {
  answer.claim = Claim::kUnsolvable;
  answer.farkas.swap(farkas);
  text = "proven by u >= 0 with M'u <= 0, q'u < 0";
}

}  // namespace lcpbench
