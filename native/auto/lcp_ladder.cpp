#include "native/auto/lcp_ladder.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench {

SolverDefinition lcpbench_solver_lemke();
SolverDefinition lcpbench_solver_principal_pivoting();
SolverDefinition lcpbench_solver_regularized();

namespace {

constexpr double kClaimedError = 5e-10;
constexpr std::size_t kLoadedAtOnce = 2;

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
      answer.claim = Claim::kSolved;
      answer.z.swap(attempt_.z);
      text = rung.name;
      return;
    }
    if (attempt_.claim == Claim::kUnsolvable && proves(attempt_.farkas)) {
      answer.claim = Claim::kUnsolvable;
      answer.farkas = attempt_.farkas;
      text = "proven by u >= 0 with M'u <= 0, q'u < 0";
      return;
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

/// u >= 0, M'u <= 0 and q'u < 0, each by more than its sum can round.
bool LcpLadder::proves(const Vector& farkas) const {
  const Lcp& lcp = problem_.lcp();
  if (farkas.size() != lcp.size() || farkas.size() == 0 || !farkas.allFinite() || !(farkas.minCoeff() >= 0)) {
    return false;
  }
  const double rounding = 4e-16 * static_cast<double>(lcp.size());
  const Vector product = lcp.M.transpose() * farkas;
  const Vector terms = lcp.M.cwiseAbs().transpose() * farkas;
  const bool blocked = (product.array() <= rounding * terms.array()).all();
  return blocked && lcp.q.dot(farkas) < -rounding * lcp.q.cwiseAbs().dot(farkas);
}

}  // namespace lcpbench
