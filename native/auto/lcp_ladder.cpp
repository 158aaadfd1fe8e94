#include "native/auto/lcp_ladder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/answer_storage.h"
#include "core/quad.h"
#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench {

SolverDefinition lcpbench_solver_lemke();
SolverDefinition lcpbench_solver_murty();
SolverDefinition lcpbench_solver_principal_pivoting();
SolverDefinition lcpbench_solver_psor();

namespace {

/// How finely the proof of another method has to hold: as well as doubles can tell.
constexpr Quad kDouble = 4e-16;

/// Above these orders 113 bits, and what Murty's method may go round in or psor sweep, take longer than a last resort
/// should.
constexpr Index kLargestQuad = 300;
constexpr Index kLargestSlow = 100;

/// The longest `detail` of the methods here, so that none allocates.
constexpr std::size_t kLongestDetail = 200;

Options with_limit(Options options, std::int64_t max_pivots) {
  if (max_pivots > 0) options.emplace_back("max_pivots", std::to_string(max_pivots));
  return options;
}

}  // namespace

void LcpLadder::make_rungs() {
  constexpr Index kAny = std::numeric_limits<Index>::max();
  const auto add = [this](const char* name, Index max_size, const SolverDefinition& method, const Options& options) {
    rungs_.push_back({name, max_size, method.make(with_limit(options, max_pivots_))});
  };
  const SolverDefinition lemke = lcpbench_solver_lemke();
  add("lemke, double", kAny, lemke, {{"pivot_tolerance", "1e-13"}, {"zero_tolerance", "1e-14"}, {"test", "none"}});
  add("lemke, loose", kAny, lemke, {{"test", "none"}});
  add("principal_pivoting", kAny, lcpbench_solver_principal_pivoting(), {});
  add("lemke, quad", kLargestQuad, lemke, {{"precision", "quad"}});
  add("murty", kLargestSlow, lcpbench_solver_murty(), {});
  rungs_.push_back({"psor", kLargestSlow, lcpbench_solver_psor().make({})});  // has no pivots to limit
}

void LcpLadder::load(const Problem& problem) {
  if (rungs_.empty()) make_rungs();
  problem_ = problem;
  test_.load(problem_.lcp());
  attempt_.z.resize(problem_.size());
  attempt_.farkas.resize(problem_.size());
  attempt_.detail.reserve(kLongestDetail);
  for (const Rung& rung : rungs_) {
    if (problem_.size() <= rung.max_size) rung.solver->load(problem_);
  }
  if (problem_.size() <= SupportSearch::kMaxSize) search_.load(problem_.lcp());
}

void LcpLadder::solve(const SolveRequest& request, Answer& answer, const char*& text) {
  const double deadline_s =
      std::isinf(request.time_limit_s) ? request.time_limit_s : wall_clock_s() + request.time_limit_s;
  answer.counters = {.iterations = 0, .pivots = 0, .factorizations = 0};
  text = "no answer passed the test";
  for (Rung& rung : rungs_) {
    if (problem_.size() > rung.max_size) continue;
    const bool first = &rung == &rungs_.front();
    SolveRequest inner = request;
    inner.start = nullptr;
    if (!std::isinf(deadline_s) && !first) inner.time_limit_s = deadline_s - wall_clock_s();
    if (!(inner.time_limit_s > 0)) {
      answer.claim = Claim::kTimeLimit;
      return;
    }
    rung.solver->solve(inner, attempt_);
    answer.counters.iterations += std::max<std::int64_t>(attempt_.counters.iterations, 0);
    answer.counters.pivots += std::max<std::int64_t>(attempt_.counters.pivots, 0);
    answer.counters.factorizations += std::max<std::int64_t>(attempt_.counters.factorizations, 0);
    if (is_final(rung, answer, text)) return;
  }
  if (problem_.size() > SupportSearch::kMaxSize) return;
  if (search_.run(deadline_s, test_, attempt_.z)) {
    answer.claim = Claim::kSolved;
    answer.z.swap(attempt_.z);
    text = "all supports";
  }
}

/// Whether attempt_ leaves nothing more to be tried; if so `answer` is what it says.
bool LcpLadder::is_final(const Rung& rung, Answer& answer, const char*& text) {
  if (attempt_.claim == Claim::kSolved && test_.backward_error(attempt_.z) <= kClaimedBackwardError) {
    if (test_.disproves(attempt_.z)) {
      report_unsolvable(test_.proof(), answer, text);
      return true;
    }
    answer.claim = Claim::kSolved;
    answer.z.swap(attempt_.z);
    text = rung.name;
    return true;
  }
  if (attempt_.claim == Claim::kUnsolvable && test_.proves(attempt_.farkas, kDouble)) {
    report_unsolvable(attempt_.farkas, answer, text);
    return true;
  }
  // All methods share the limit: what one has used up, the next would exceed.
  if (max_pivots_ > 0 && answer.counters.pivots >= max_pivots_) {
    answer.claim = Claim::kIterationLimit;
    text = "pivot limit";
    return true;
  }
  if (attempt_.claim == Claim::kTimeLimit) answer.claim = Claim::kTimeLimit;
  return attempt_.claim == Claim::kTimeLimit;
}

/// As unsolvable, with its proof, which `farkas` is.
void LcpLadder::report_unsolvable(const Vector& proof, Answer& answer, const char*& text) {
  answer.claim = Claim::kUnsolvable;
  Vector& farkas = cleared_vectors().farkas;
  farkas = proof;
  answer.farkas.swap(farkas);
  text = "proven by u >= 0 with M'u <= 0, q'u < 0";
}

}  // namespace lcpbench
