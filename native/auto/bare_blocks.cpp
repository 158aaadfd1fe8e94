#include "native/auto/bare_blocks.h"

#include <algorithm>
#include <string>

#include "core/islands.h"
#include "core/mixed_lcp.h"
#include "core/timed_solve.h"
#include "native/answer_test/bare_lcp_test.h"

namespace lcpbench {

const Capabilities& BareBlocks::capabilities() const {
  static constexpr Capabilities kBare{.obeys_time_limit = true};
  return kBare;
}

void BareBlocks::on_load(const Problem& problem) {
  pairs_.clear();
  if (joins_pairs_) pairs_ = split_unknowns(problem.lcp());
  if (!pairs_.empty()) {
    // Unknowns that cannot be eliminated come back as the same pairs.
    if (free_ == nullptr) free_ = std::make_unique<BareBlocks>(false);
    free_->load(Problem("", with_free_unknowns(problem.lcp(), pairs_, of_free_)));
  }
  const RowIslands islands = row_islands(problem.lcp().M);
  blocks_.clear();
  if (islands.count < 2) return lcp_.load(problem);
  blocks_.resize(static_cast<std::size_t>(islands.count));
  for (Index i = 0; i < problem.size(); ++i) {
    blocks_[static_cast<std::size_t>(islands.of_row[static_cast<std::size_t>(i)])].push_back(i);
  }
}

void BareBlocks::on_solve(const SolveRequest& request, Answer& answer) {
  const double deadline_s = wall_clock_s() + request.time_limit_s;
  if (!pairs_.empty() && solve_with_free_unknowns(request, answer)) return;
  if (blocks_.empty()) return lcp_.solve({.time_limit_s = deadline_s - wall_clock_s()}, answer);
  solve_blocks(deadline_s, answer);
}

/// In half of the time. False, and the answer is as it was, where that gives no solution.
bool BareBlocks::solve_with_free_unknowns(const SolveRequest& request, Answer& answer) {
  const double time_limit_s = request.time_limit_s / 2;
  free_->solve({.time_limit_s = time_limit_s}, part_);
  if (part_.claim != Claim::kSolved) return false;
  answer.z(of_free_) = part_.z;
  for (const auto& [positive, negative] : pairs_) {
    answer.z(negative) = std::max(0.0, -answer.z(positive));
    answer.z(positive) = std::max(0.0, answer.z(positive));
  }
  BareLcpTest test;
  test.load(problem().lcp());
  const bool solves = test.backward_error(answer.z) <= kClaimedBackwardError;
  if (!solves || test.disproves(answer.z, wall_clock_s() + time_limit_s)) {
    answer.z.setZero();
    return false;
  }
  answer.claim = Claim::kSolved;
  answer.counters = part_.counters;
  answer.detail = std::to_string(pairs_.size()) + " free unknowns; " + part_.detail;
  return true;
}

/// Each block may take the time that is left.
void BareBlocks::solve_blocks(double deadline_s, Answer& answer) {
  const Lcp& whole = problem().lcp();
  answer.claim = Claim::kSolved;
  answer.counters = {.iterations = 0, .pivots = 0, .factorizations = 0};
  answer.detail = std::to_string(blocks_.size()) + " blocks";
  for (const std::vector<Index>& rows : blocks_) {
    if (whole.q(rows).minCoeff() >= 0) continue;  // z = 0 solves it
    const Problem block("", Lcp{whole.M(rows, rows), whole.q(rows)});
    part_.reserve(block);
    part_.clear();
    lcp_.load(block);
    lcp_.solve({.time_limit_s = deadline_s - wall_clock_s()}, part_);
    answer.counters.iterations += part_.counters.iterations;
    answer.counters.pivots += part_.counters.pivots;
    answer.counters.factorizations += part_.counters.factorizations;
    if (part_.claim == Claim::kSolved) answer.z(rows) = part_.z;
    if (part_.claim == Claim::kSolved || (answer.claim != Claim::kSolved && part_.claim != Claim::kUnsolvable)) continue;
    answer.claim = part_.claim;
    answer.detail = "block of " + std::to_string(rows.size()) + " rows, from row " + std::to_string(rows.front()) +
                    ": " + part_.detail;
    if (part_.claim != Claim::kUnsolvable) continue;
    answer.z.setZero();
    if (part_.farkas.size() == 0) return;
    answer.farkas = Vector::Zero(whole.size());
    answer.farkas(rows) = part_.farkas;
    return;
  }
}

}  // namespace lcpbench
