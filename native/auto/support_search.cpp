#include "native/auto/support_search.h"

#include <algorithm>
#include <utility>

#include "core/timed_solve.h"

namespace lcpbench {
namespace {

/// Pivots that elimination leaves of larger entries by rounding alone, and entries of z below zero by as much.
constexpr double kNoise = 0x1p-90;

}  // namespace

void SupportSearch::load(const Lcp& lcp) {
  n_ = lcp.size();
  for (Index i = 0; i < n_; ++i) {
    auto& row = data_[static_cast<std::size_t>(i)];
    for (Index j = 0; j < n_; ++j) row[static_cast<std::size_t>(j)] = lcp.M(i, j);
    row[static_cast<std::size_t>(n_)] = -static_cast<Quad>(lcp.q(i));
  }
}

bool SupportSearch::run(double deadline_s, BareLcpTest& test, Vector& z) {
  for (unsigned support = 0; support < 1U << n_; ++support) {
    if (!(wall_clock_s() < deadline_s)) return false;
    if (solve(support, z) && test.backward_error(z) <= kClaimedBackwardError && !test.disproves(z)) return true;
  }
  return false;
}

/// The z >= 0 with this support for which w vanishes there; false where there is none, or the block is singular.
bool SupportSearch::solve(unsigned support, Vector& z) {
  std::size_t order = 0;
  for (Index i = 0; i < n_; ++i) {
    if ((support >> i & 1U) != 0) members_[order++] = i;
  }
  for (std::size_t r = 0; r < order; ++r) {
    const auto& row = data_[static_cast<std::size_t>(members_[r])];
    for (std::size_t c = 0; c < order; ++c) rows_[r][c] = row[static_cast<std::size_t>(members_[c])];
    rows_[r][order] = row[static_cast<std::size_t>(n_)];
  }
  for (std::size_t step = 0; step < order; ++step) {
    std::size_t pivot = step;
    Quad before = 0;  // the largest entry that this column had
    for (std::size_t r = 0; r < order; ++r) {
      const auto& row = data_[static_cast<std::size_t>(members_[r])];
      before = std::max(before, abs(row[static_cast<std::size_t>(members_[step])]));
      if (r > step && abs(rows_[r][step]) > abs(rows_[pivot][step])) pivot = r;
    }
    if (!(abs(rows_[pivot][step]) > kNoise * before)) return false;
    std::swap(rows_[step], rows_[pivot]);
    for (std::size_t r = step + 1; r < order; ++r) {
      const Quad factor = rows_[r][step] / rows_[step][step];
      for (std::size_t c = step + 1; c <= order; ++c) rows_[r][c] -= factor * rows_[step][c];
    }
  }
  Quad largest = 0;
  for (std::size_t r = order; r-- > 0;) {
    Quad& value = rows_[r][order];
    for (std::size_t c = r + 1; c < order; ++c) value -= rows_[r][c] * rows_[c][order];
    value /= rows_[r][r];
    largest = std::max(largest, abs(value));
  }
  z.setZero();
  for (std::size_t r = 0; r < order; ++r) {
    const Quad value = rows_[r][order];
    if (!(value >= -kNoise * largest)) return false;
    z(members_[r]) = std::max(0.0, to_double(value));
  }
  return true;
}

}  // namespace lcpbench
