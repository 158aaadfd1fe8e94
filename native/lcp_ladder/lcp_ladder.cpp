#include "native/lcp_ladder/lcp_ladder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/timed_solve.h"

namespace lcpbench {
namespace {

/// An answer with a larger backward error passes, but later stages may still find a better one.
constexpr double kAccurate = 1e-9;

/// Tolerances near rounding.
constexpr double kTightPivot = 1e-13;
constexpr double kTightZero = 1e-14;

/// Up to this order all stages may run: together they take some tens of milliseconds. Above it the ladder leaves out
/// what costs much and hardly ever finds an answer: all after CoveringLemke in double where lemke ended in a ray; 113
/// bits where no path in double ended near an answer, or where 113 bits could not go as far; tight tolerances; and the
/// other covering vector.
constexpr Index kLargestThorough = 40;

/// Pivots of CoveringLemke for each pivot before it, above that order, where lemke ended in a ray.
constexpr std::int64_t kPivotsAfterRay = 2;

/// Systems of equations that the last stage solves before it gives up: seconds at most.
constexpr std::int64_t kMostSystems = 20000;

/// Of all paths through a game together, for each unknown: most take n or less.
constexpr std::int64_t kGamePivots = 100;

/// Entries of tableaus that a stage in 113 bits changes: about a second.
constexpr std::int64_t kMostQuadWork = 10'000'000;

LemkeSettings tested() {
  LemkeSettings settings;
  settings.test = LemkeAnswerTest::kResidual;
  return settings;
}

}  // namespace

LcpLadder::LcpLadder() : lemke_(tested()) {}

void LcpLadder::load(const Problem& problem) {
  problem_ = problem;
  lemke_.load(problem_);
  if (!takes()) return;
  is_sparse_ = sparse_.load(problem_.lcp());
  is_game_ = game_.load(problem_.lcp());
  covering_.load(problem_.lcp());
  attempt_.reserve(problem_);
}

bool LcpLadder::has(Stage stage) const {
  switch (stage) {
    case Stage::kSparse: return is_sparse_;
    case Stage::kGame: return is_game_;
    case Stage::kCoveringQuad:
      if (problem_.size() <= kLargestThorough) return true;
      return is_inaccurate_ && problem_.size() <= CoveringLemke::kLargestQuad && covering_pivots_ <= quad_pivots();
    case Stage::kLemkeTight:
    case Stage::kCoveringQuadNegative: return problem_.size() <= kLargestThorough;
    case Stage::kLemkeLong: return ended_by_share_;
    case Stage::kExact: return problem_.size() <= kLargestExact;
    default: return true;
  }
}

/// Of a stage in 113 bits.
std::int64_t LcpLadder::quad_pivots() const {
  const std::int64_t n = problem_.size();
  return kMostQuadWork / std::max<std::int64_t>(n * (n + 3), 1);
}

/// Of lemke, where other stages follow.
std::int64_t LcpLadder::share_of_pivots() const {
  return 50 + 4 * problem_.size();
}

void LcpLadder::solve(const SolveRequest& request, Answer& answer, const char*& text) {
  deadline_s_ = std::isinf(request.time_limit_s) ? request.time_limit_s : wall_clock_s() + request.time_limit_s;
  answer.counters = {.iterations = 0, .pivots = 0, .factorizations = 0};
  text = takes() ? "no answer passed the test" : "n is over the limit of lemke";
  if (!takes()) return;
  struct Step {
    Stage stage;
    const char* name;
    void (LcpLadder::*run)(Stage);
  };
  constexpr std::array kSteps{
      Step{Stage::kSparse, "sparse principal pivoting", &LcpLadder::run_sparse},
      Step{Stage::kGame, "lemke-howson", &LcpLadder::run_game},
      Step{Stage::kLemke, "lemke", &LcpLadder::run_lemke},
      Step{Stage::kCovering, "covering lemke", &LcpLadder::run_covering},
      Step{Stage::kLemkeTight, "lemke, tight tolerances", &LcpLadder::run_lemke},
      Step{Stage::kCoveringQuad, "covering lemke, quad", &LcpLadder::run_covering},
      Step{Stage::kCoveringQuadNegative, "covering lemke, quad, rows with q < 0", &LcpLadder::run_covering},
      Step{Stage::kLemkeLong, "lemke", &LcpLadder::run_lemke},
      Step{Stage::kExact, "all supports", &LcpLadder::run_exact}};
  pivots_ = 0;
  ended_by_share_ = ended_in_ray_ = is_inaccurate_ = false;
  least_error_ = std::numeric_limits<double>::infinity();
  for (const auto& [stage, name, run] : kSteps) {
    if (!has(stage)) continue;
    if (!(wall_clock_s() < deadline_s_)) {
      if (answer.claim != Claim::kSolved) answer.claim = Claim::kTimeLimit;
      return;
    }
    (this->*run)(stage);
    answer.counters.iterations += std::max<std::int64_t>(attempt_.counters.iterations, 0);
    answer.counters.pivots += std::max<std::int64_t>(attempt_.counters.pivots, 0);
    answer.counters.factorizations += std::max<std::int64_t>(attempt_.counters.factorizations, 0);
    pivots_ = answer.counters.pivots;
    is_inaccurate_ = is_inaccurate_ || attempt_.detail == "residual";
    if (attempt_.claim == Claim::kSolved) {
      const double error = lemke_.answer_test().backward_error();
      if (error < least_error_) {
        answer.claim = Claim::kSolved;
        answer.z = attempt_.z;
        text = name;
        least_error_ = error;
      }
      if (error <= kAccurate) return;
      is_inaccurate_ = true;
    } else if (is_final(stage, answer, text)) {
      return;
    }
  }
}

void LcpLadder::run_sparse(Stage /*stage*/) {
  attempt_.clear();
  attempt_.z.resize(problem_.size());
  const SparsePivoting::End end = sparse_.run(deadline_s_, attempt_.z);
  const SparsePivoting::Counts& counts = sparse_.counts();
  attempt_.counters = {.iterations = counts.steps, .pivots = counts.exchanges, .factorizations = counts.factorizations};
  if (end == SparsePivoting::End::kTimeLimit) attempt_.claim = Claim::kTimeLimit;
  if (end != SparsePivoting::End::kSolved) return;
  attempt_.claim = Claim::kSolved;
  lemke_.answer_test().settle(attempt_, deadline_s_);
}

/// Drops one pair after the other.
void LcpLadder::run_game(Stage /*stage*/) {
  const Index n = problem_.size();
  std::int64_t left = kGamePivots * n, pivots = 0;
  for (Index dropped = 0; dropped < n && left > 0; ++dropped) {
    attempt_.clear();
    attempt_.z.resize(n);
    const LemkeHowson::End end = game_.run(dropped, left, deadline_s_, attempt_.z);
    left -= std::max<std::int64_t>(game_.pivots(), 1);
    pivots += game_.pivots();
    if (end == LemkeHowson::End::kTimeLimit) attempt_.claim = Claim::kTimeLimit;
    if (end == LemkeHowson::End::kSolved) {
      attempt_.claim = Claim::kSolved;
      lemke_.answer_test().settle(attempt_, deadline_s_);
    }
    attempt_.counters = {.iterations = pivots, .pivots = pivots, .factorizations = 0};
    if (attempt_.claim == Claim::kSolved || attempt_.claim == Claim::kTimeLimit) return;
  }
}

void LcpLadder::run_lemke(Stage stage) {
  const LemkeSettings defaults;
  const bool tight = stage == Stage::kLemkeTight;
  lemke_.use_tolerances(tight ? kTightPivot : defaults.pivot_tolerance, tight ? kTightZero : defaults.zero_tolerance);
  std::int64_t limit = share_of_pivots();
  if (stage == Stage::kLemkeLong) {
    limit = std::min<std::int64_t>(1000 + 20 * problem_.size(), lemke_pivot_limit(defaults, problem_.size()));
  }
  lemke_.limit_pivots(limit);
  const bool unlimited = std::isinf(deadline_s_);
  lemke_.solve({.time_limit_s = unlimited ? deadline_s_ : deadline_s_ - wall_clock_s()}, attempt_);
  if (stage == Stage::kLemke) {
    ended_in_ray_ = attempt_.claim == Claim::kNumericalFailure && attempt_.detail == "ray";
    ended_by_share_ = attempt_.claim == Claim::kIterationLimit && limit < lemke_pivot_limit(defaults, problem_.size());
  }
}

void LcpLadder::run_covering(Stage stage) {
  using Cover = CoveringLemke::Cover;
  const Index n = problem_.size();
  CoveringLemke::Limits limits{.deadline_s = deadline_s_, .pivots = 500 + 10 * n};
  if (ended_in_ray_ && n > kLargestThorough) limits.pivots = std::min(limits.pivots, 50 + kPivotsAfterRay * pivots_);
  if (stage != Stage::kCovering) limits.pivots = std::min(limits.pivots, quad_pivots());
  const Cover cover = stage == Stage::kCoveringQuadNegative ? Cover::kNegative : Cover::kAll;
  attempt_.clear();
  attempt_.z.resize(n);
  const CoveringLemke::End end = stage == Stage::kCovering ? covering_.run<double>(cover, limits, attempt_.z)
                                                         : covering_.run<Quad>(cover, limits, attempt_.z);
  if (stage == Stage::kCovering) covering_pivots_ = covering_.pivots();
  attempt_.counters = {.iterations = covering_.pivots(), .pivots = covering_.pivots(), .factorizations = 0};
  if (end == CoveringLemke::End::kSolved) {
    attempt_.claim = Claim::kSolved;
    lemke_.answer_test().settle(attempt_, deadline_s_);
  } else if (end == CoveringLemke::End::kTimeLimit) {
    attempt_.claim = Claim::kTimeLimit;
  }
}

void LcpLadder::run_exact(Stage /*stage*/) {
  using End = SupportSearch::End;
  supports_.load(problem_.lcp());
  attempt_.clear();
  const End end = supports_.run(deadline_s_, kMostSystems);
  if (end == End::kTimeLimit) attempt_.claim = Claim::kTimeLimit;
  if (end != End::kFound) return;
  attempt_.z = supports_.z();
  attempt_.claim = Claim::kSolved;
  lemke_.answer_test().settle(attempt_, deadline_s_);
}

/// Whether attempt_, which solves nothing, leaves nothing more to be tried; if so `answer` and `text` are what it says,
/// unless there is an answer already.
bool LcpLadder::is_final(Stage stage, Answer& answer, const char*& text) {
  if (attempt_.claim == Claim::kUnsolvable) {
    answer.claim = Claim::kUnsolvable;
    answer.z.setZero();
    answer.farkas = attempt_.farkas;
    text = "proven by u >= 0 with M'u <= 0, q'u < 0";
    return true;
  }
  if (answer.claim == Claim::kSolved) return attempt_.claim == Claim::kTimeLimit;
  if (attempt_.claim == Claim::kTimeLimit) {
    answer.claim = Claim::kTimeLimit;
    return true;
  }
  if (ended_in_ray_ && problem_.size() > kLargestThorough) {
    if (stage == Stage::kLemke && lemke_.answer_test().nearly_disproved()) {
      text = "ray: unsolvable to rounding, without a proof in doubles";
      return true;
    }
    if (stage == Stage::kCovering) {
      text = "ray, and no answer with another covering vector";
      return true;
    }
  }
  return false;
}

}  // namespace lcpbench
