#include "native/auto/bare_lcp.h"

#include <algorithm>
#include <memory>

#include "core/registry.h"
#include "core/spec.h"
#include "core/timed_solve.h"
#include "native/proofs/support_search.h"

namespace lcpbench {

void BareLcp::load(const Problem& problem) {
  problem_ = problem;
  attempt_.reserve(problem_);
  is_game_ = game_.load(problem_.lcp());
  if (is_game_) test_.load(problem_);
  lemke_.load(problem_);
  lemke_.limit_pivots(max_pivots());
}

/// Of a path: most have n or fewer, but those of a few unknowns may be exponentially long.
std::int64_t BareLcp::max_pivots() const { return std::max<std::int64_t>(5000, 4 * problem_.size()); }

void BareLcp::solve(const SolveRequest& request, Answer& answer) {
  const double deadline_s = wall_clock_s() + request.time_limit_s;
  const auto time_left = [&] { return SolveRequest{.time_limit_s = deadline_s - wall_clock_s()}; };
  answer.counters = {.iterations = 0, .pivots = 0, .factorizations = 0};
  if (is_game_) {
    play_game(deadline_s);
    if (is_settled("lemke-howson", answer)) return;
  }
  lemke_.solve(time_left(), attempt_);
  if (is_settled("lemke", answer)) return;
  const std::string limit = "max_pivots=" + std::to_string(max_pivots());
  for (const std::string& text : {"principal_pivoting{" + limit + "}",
                                  "regularized{solver=lemke{cover=all," + limit + ",test=none}}"}) {
    const Spec spec = parse_spec(text);
    const std::unique_ptr<Solver> method = make_solver(spec);
    method->load(problem_);
    method->solve(time_left(), attempt_);
    if (is_settled(spec.name, answer)) return;
  }
  if (problem_.size() <= SupportSearch::kMaxSize) {
    search_supports(deadline_s);
    if (is_settled("all supports", answer)) return;
  }
  answer.detail = "no answer passed the test";
}

/// Drops one pair after the other, until an answer passes the test.
void BareLcp::play_game(double deadline_s) {
  attempt_.reserve(problem_);
  attempt_.counters = {.iterations = 0, .pivots = 0, .factorizations = 0};
  attempt_.z.resize(problem_.size());
  for (Index dropped = 0; dropped < problem_.size() && attempt_.counters.pivots < max_pivots(); ++dropped) {
    const auto end = game_.run(dropped, max_pivots() - attempt_.counters.pivots, deadline_s, attempt_.z);
    attempt_.counters.iterations = attempt_.counters.pivots += game_.pivots();
    if (end == LemkeHowson::End::kSolved) attempt_.claim = Claim::kSolved;
    if (end == LemkeHowson::End::kTimeLimit) attempt_.claim = Claim::kTimeLimit;
    if (attempt_.claim == Claim::kTimeLimit || test_.settle(attempt_, deadline_s)) return;
  }
}

void BareLcp::search_supports(double deadline_s) {
  constexpr std::int64_t kMaxSystems = 20000;  // seconds at most
  SupportSearch search;
  search.load(problem_.lcp());
  test_.load(problem_);
  attempt_.reserve(problem_);
  const SupportSearch::End end = search.run(deadline_s, kMaxSystems);
  if (end == SupportSearch::End::kTimeLimit) attempt_.claim = Claim::kTimeLimit;
  if (end != SupportSearch::End::kFound) return;
  attempt_.claim = Claim::kSolved;
  attempt_.z = search.z();
  test_.settle(attempt_, deadline_s);
}

/// Whether nothing more is to be tried after attempt_; then `answer` is what it says.
bool BareLcp::is_settled(const std::string& method, Answer& answer) const {
  answer.counters.iterations += std::max<std::int64_t>(attempt_.counters.iterations, 0);
  answer.counters.pivots += std::max<std::int64_t>(attempt_.counters.pivots, 0);
  answer.counters.factorizations += std::max<std::int64_t>(attempt_.counters.factorizations, 0);
  const Claim claim = attempt_.claim;
  if (claim == Claim::kNumericalFailure || claim == Claim::kIterationLimit) return false;
  answer.claim = claim == Claim::kUnsupported ? Claim::kNumericalFailure : claim;
  answer.detail = method;
  if (claim == Claim::kSolved) answer.z = attempt_.z;
  if (claim == Claim::kUnsolvable) answer.farkas = attempt_.farkas;
  if (claim == Claim::kUnsolvable) answer.detail += ": proven by u >= 0 with M'u <= 0, q'u < 0";
  if (claim == Claim::kUnsupported) answer.detail += ": " + attempt_.detail;
  return true;
}

}  // namespace lcpbench
