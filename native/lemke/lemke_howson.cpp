#include "native/lemke/lemke_howson.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/timed_solve.h"

namespace lcpbench {
namespace {

/// Relative to the largest entry of its column: below, an entry is rounding, and no pivot.
constexpr double kPivot = 1e-11;
/// Ratios that differ by less, relatively, tie.
constexpr double kTie = 1e-12;

}  // namespace

bool LemkeHowson::load(const Lcp& lcp) {
  const Index n = lcp.size();
  lcp_ = nullptr;
  if (n < 2 || n > kLargest || !(lcp.q.maxCoeff() < 0) || lcp.M(0, 0) != 0 || !(lcp.M.minCoeff() >= 0)) return false;
  side_.assign(static_cast<std::size_t>(n), false);
  std::vector<bool> known(static_cast<std::size_t>(n), false);
  std::vector<Index> next{0};
  known[0] = true;
  while (!next.empty()) {
    const Index i = next.back();
    next.pop_back();
    for (Index j = 0; j < n; ++j) {
      const auto at = static_cast<std::size_t>(j);
      if (known[at] || (lcp.M(i, j) == 0 && lcp.M(j, i) == 0)) continue;
      known[at] = true;
      side_[at] = !side_[static_cast<std::size_t>(i)];
      next.push_back(j);
    }
  }
  if (std::find(known.begin(), known.end(), false) != known.end()) return false;
  for (Index j = 0; j < n; ++j) {
    for (Index i = 0; i < n; ++i) {
      if (lcp.M(i, j) != 0 && side_[static_cast<std::size_t>(i)] == side_[static_cast<std::size_t>(j)]) return false;
    }
  }
  lcp_ = &lcp;
  tableau_.resize(n, n + 2);
  entering_.resize(n + 2);
  basic_.resize(static_cast<std::size_t>(n));
  nonbasic_.resize(static_cast<std::size_t>(n));
  return true;
}

/// Rows are scaled so that q is -1.
void LemkeHowson::fill() {
  const Index n = lcp_->size();
  for (Index i = 0; i < n; ++i) tableau_.row(i).head(n) = lcp_->M.row(i) / -lcp_->q(i);
  tableau_.col(n).setConstant(-1);
  std::uint32_t random = 1;
  for (Index i = 0; i < n; ++i) {
    random = random * 1664525U + 1013904223U;
    tableau_(i, n + 1) = 1 + static_cast<double>(random >> 8) * 0x1p-24;
    basic_[static_cast<std::size_t>(i)] = i;
    nonbasic_[static_cast<std::size_t>(i)] = n + i;
  }
}

void LemkeHowson::exchange(Index row, Index column) {
  const double pivot = tableau_(row, column);
  tableau_.row(row) /= -pivot;
  tableau_(row, column) = 1 / pivot;
  entering_ = tableau_.row(row);
  for (Index i = 0; i < tableau_.rows(); ++i) {
    if (i == row) continue;
    const double factor = tableau_(i, column);
    if (factor == 0) continue;
    tableau_(i, column) = 0;
    tableau_.row(i) += factor * entering_;
  }
  std::swap(basic_[static_cast<std::size_t>(row)], nonbasic_[static_cast<std::size_t>(column)]);
  ++pivots_;
}

/// Of the rows of a side, all of which are negative, the one that becomes zero last as the column's unknown grows; -1
/// where some never does.
Index LemkeHowson::last_to_rise(Index column, bool side) const {
  const Index n = tableau_.rows();
  Index last = -1;
  double largest = 0;
  for (Index i = 0; i < n; ++i) {
    if (side_[static_cast<std::size_t>(i)] != side) continue;
    if (!(tableau_(i, column) > 0)) return -1;
    const double ratio = -tableau_(i, n) / tableau_(i, column);
    const bool ties = last >= 0 && std::abs(ratio - largest) <= kTie * largest;
    const auto behind = [&](Index row) { return tableau_(row, n + 1) / tableau_(row, column); };
    if (last < 0 || (ties ? behind(i) < behind(last) : ratio > largest)) {
      last = i;
      largest = ratio;
    }
  }
  return last;
}

/// The row that becomes zero first as the column's unknown grows; -1: none does.
Index LemkeHowson::first_to_fall(Index column) const {
  const Index n = tableau_.rows();
  const double least_pivot = kPivot * tableau_.col(column).cwiseAbs().maxCoeff();
  Index first = -1;
  double least = 0;
  for (Index i = 0; i < n; ++i) {
    if (!(tableau_(i, column) < -least_pivot)) continue;
    const double ratio = std::max(0.0, tableau_(i, n)) / -tableau_(i, column);
    const bool ties = first >= 0 && std::abs(ratio - least) <= kTie * std::max(least, ratio);
    const auto behind = [&](Index row) { return tableau_(row, n + 1) / -tableau_(row, column); };
    if (first < 0 || (ties ? behind(i) < behind(first) : ratio < least)) {
      first = i;
      least = ratio;
    }
  }
  return first;
}

LemkeHowson::End LemkeHowson::run(Index dropped, std::int64_t most_pivots, double deadline_s, Vector& z) {
  const Index n = lcp_->size();
  pivots_ = 0;
  fill();
  const bool side = side_[static_cast<std::size_t>(dropped)];
  const Index other = last_to_rise(dropped, !side);
  if (other < 0) return End::kFailed;
  exchange(other, dropped);
  Index column = other;  // of the z that is the complement of what has left
  Index row = last_to_rise(column, side);
  if (row < 0) return End::kFailed;
  while (true) {
    const Index left = basic_[static_cast<std::size_t>(row)];
    exchange(row, column);
    if (left % n == dropped) break;
    if (pivots_ >= most_pivots) return End::kFailed;
    if (!(wall_clock_s() < deadline_s)) return End::kTimeLimit;
    const Index entering = left < n ? left + n : left - n;
    column = std::find(nonbasic_.begin(), nonbasic_.end(), entering) - nonbasic_.begin();
    row = first_to_fall(column);
    if (row < 0) return End::kFailed;
  }
  z.setZero();
  for (Index i = 0; i < n; ++i) {
    const Index name = basic_[static_cast<std::size_t>(i)];
    if (name >= n) z(name - n) = std::max(0.0, tableau_(i, n));
  }
  return End::kSolved;
}

}  // namespace lcpbench
