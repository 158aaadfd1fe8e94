#include "native/answer_test/exact_search.h"

#include <algorithm>

#include "core/timed_solve.h"

namespace lcpbench::enumeration {
namespace {

bool contains(std::uint32_t set, Index i) { return (set >> i & 1U) != 0; }

void list_members(std::uint32_t set, std::vector<Index>& members) {
  members.clear();
  for (Index i = 0; i < ExactSearch::kMaxSize; ++i) {
    if (contains(set, i)) members.push_back(i);
  }
}

}  // namespace

void ExactSearch::reserve(Index n) {
  rows_.reserve(n);
  system_.reserve(n);
  support_.reserve(static_cast<std::size_t>(kMaxSize));
  others_.reserve(static_cast<std::size_t>(kMaxSize));
}

void ExactSearch::load(const Lcp& lcp) {
  n_ = lcp.size();
  rows_.load(lcp);
  system_.load(rows_);
  support_.reserve(static_cast<std::size_t>(kMaxSize));
  others_.reserve(static_cast<std::size_t>(kMaxSize));
}

bool ExactSearch::is_solution() {
  ++systems_;
  system_.solve();
  for (std::size_t j = 0; j < support_.size(); ++j) {
    if (is_negative(system_.numerator(j))) return false;
  }
  return std::none_of(others_.begin(), others_.end(), [this](Index row) { return system_.is_violated(row); });
}

/// Tries every point that the system and rows w_j = 0, j >= first_row outside the support, determine. Leaves the system
/// as it was, or, where it finds one, at the solution.
bool ExactSearch::complete(Index first_row) {
  if (stopped_ == End::kNone && !(wall_clock_s() < deadline_s_)) stopped_ = End::kTimeLimit;
  if (stopped_ == End::kNone && systems_ >= most_systems_) stopped_ = End::kSystemLimit;
  if (stopped_ != End::kNone) return false;
  if (system_.full_rank()) return is_solution();
  for (const Index row : others_) {
    if (row < first_row || stopped_ != End::kNone) continue;
    if (system_.add(row) != System::Row::kIndependent) continue;
    if (complete(row + 1)) return true;
    system_.remove_last();
  }
  return false;
}

void ExactSearch::start(std::uint32_t support) {
  list_members(support, support_);
  list_members(~support & ((std::uint32_t{1} << n_) - 1), others_);
  system_.start(support_);
}

bool ExactSearch::find_with_support(std::uint32_t support) {
  start(support);
  for (const Index row : support_) {
    if (system_.add(row) == System::Row::kInconsistent) return false;
  }
  return complete(0);
}

bool ExactSearch::solves_with(const std::vector<Index>& support) {
  std::uint32_t set = 0;
  for (const Index i : support) set |= std::uint32_t{1} << i;
  start(set);
  for (const Index row : support_) {
    if (system_.add(row) != System::Row::kIndependent) return false;
  }
  return is_solution();
}

ExactSearch::End ExactSearch::run(double deadline_s, std::int64_t most_systems) {
  deadline_s_ = deadline_s;
  most_systems_ = most_systems;
  stopped_ = End::kNone;
  systems_ = 0;
  for (std::uint32_t support = 0; support < std::uint32_t{1} << n_ && stopped_ == End::kNone; ++support) {
    if (find_with_support(support)) return End::kFound;
  }
  return stopped_;
}

}  // namespace lcpbench::enumeration
