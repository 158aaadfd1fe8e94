#include "native/proofs/support_search.h"

#include <algorithm>
#include <cmath>

#include "core/answer/lcp_error.h"
#include "core/timed_solve.h"

namespace lcpbench {
namespace {

/// A difference of less than this, relative to what was subtracted, is rounding.
constexpr Quad kNoise = 0x1p-90;
constexpr Quad kSolved = 0x1p-100;

void subtract(Quad& from, Quad x) {
  const Quad size = std::max(abs(from), abs(x));
  from -= x;
  if (abs(from) <= kNoise * size) from = 0;
}

}  // namespace

/// @returns whether the row, on the support, is independent of rows_, to which it then belongs
bool SupportSearch::add_if_independent(Index row) {
  const std::size_t order = support_.size();
  std::vector<Quad> entries(order + 1);
  for (std::size_t j = 0; j < order; ++j) entries[j] = lcp_->M(row, support_[j]);
  entries[order] = lcp_->q(row);
  for (std::size_t r = 0; r < reduced_.size(); ++r) {
    if (entries[pivots_[r]] == 0) continue;
    const Quad factor = entries[pivots_[r]] / reduced_[r][pivots_[r]];
    for (std::size_t j = 0; j <= order; ++j) subtract(entries[j], factor * reduced_[r][j]);
    entries[pivots_[r]] = 0;
  }
  const auto size = [&](std::size_t j) { return abs(entries[j]) / column_size_[static_cast<std::size_t>(support_[j])]; };
  std::size_t pivot = 0;
  for (std::size_t j = 1; j < order; ++j) {
    if (size(j) > size(pivot)) pivot = j;
  }
  if (order == 0 || entries[pivot] == 0) return false;
  rows_.push_back(row);
  reduced_.push_back(std::move(entries));
  pivots_.push_back(pivot);
  return true;
}

/// Whether the point that rows_ determine solves the LCP; then z_ is that point, rounded.
bool SupportSearch::try_rows() {
  --systems_left_;
  const std::size_t order = support_.size();
  std::vector<Quad> of_support(order, 0), z(static_cast<std::size_t>(lcp_->size()), 0);
  for (std::size_t r = order; r-- > 0;) {
    Quad sum = -reduced_[r][order];
    for (std::size_t j = 0; j < order; ++j) {
      if (j != pivots_[r]) subtract(sum, reduced_[r][j] * of_support[j]);
    }
    of_support[pivots_[r]] = sum / reduced_[r][pivots_[r]];
  }
  for (std::size_t j = 0; j < order; ++j) {
    if (!(of_support[j] >= 0)) return false;
    z[static_cast<std::size_t>(support_[j])] = of_support[j];
  }
  if (!(lcp_error<Quad>(*lcp_, z).backward <= kSolved)) return false;
  z_.resize(lcp_->size());
  std::transform(z.begin(), z.end(), z_.begin(), [](Quad value) { return to_double(value); });
  return true;
}

/// Tries every point that rows_ and further rows w_j = 0, of others_ from first_other on, determine. Leaves rows_ as
/// they were. @returns whether one solves the LCP
bool SupportSearch::complete(std::size_t first_other) {
  if (stopped_ == End::kNone && !(wall_clock_s() < deadline_s_)) stopped_ = End::kTimeLimit;
  if (stopped_ == End::kNone && systems_left_ <= 0) stopped_ = End::kSystemLimit;
  if (stopped_ != End::kNone) return false;
  if (rows_.size() == support_.size()) return try_rows();
  for (std::size_t k = first_other; k < others_.size() && stopped_ == End::kNone; ++k) {
    if (!add_if_independent(others_[k])) continue;
    if (complete(k + 1)) return true;
    rows_.pop_back();
    reduced_.pop_back();
    pivots_.pop_back();
  }
  return false;
}

void SupportSearch::load(const Lcp& lcp) {
  lcp_ = &lcp;
  column_size_.assign(static_cast<std::size_t>(lcp.size()), 0);
  for (Index j = 0; j < lcp.size(); ++j) {
    Quad& size = column_size_[static_cast<std::size_t>(j)];
    for (const double entry : lcp.M.col(j)) size = std::max(size, Quad{std::abs(entry)});
    if (size == 0) size = 1;
  }
}

SupportSearch::End SupportSearch::run(double deadline_s, std::int64_t most_systems) {
  deadline_s_ = deadline_s;
  systems_left_ = most_systems;
  stopped_ = End::kNone;
  for (std::uint32_t set = 0; set < std::uint32_t{1} << lcp_->size() && stopped_ == End::kNone; ++set) {
    for (auto* list : {&support_, &others_, &rows_}) list->clear();
    reduced_.clear();
    pivots_.clear();
    for (Index i = 0; i < lcp_->size(); ++i) ((set >> i & 1U) != 0 ? support_ : others_).push_back(i);
    for (const Index row : support_) add_if_independent(row);
    if (complete(0)) return End::kFound;
  }
  return stopped_;
}

}  // namespace lcpbench
