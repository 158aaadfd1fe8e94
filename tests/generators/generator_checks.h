#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "core/quad.h"
#include "generators/column_major.h"

// Exact and statistical checks that several tests of the generators need.

namespace lcpbench::checks {

constexpr std::uint64_t kPrime = (std::uint64_t{1} << 61) - 1;

inline std::uint64_t times_mod(std::uint64_t a, std::uint64_t b) {
  __extension__ using Wide = unsigned __int128;
  return static_cast<std::uint64_t>(static_cast<Wide>(a) * b % kPrime);
}

inline std::uint64_t inverse_mod(std::uint64_t a) {
  std::uint64_t result = 1;
  for (std::uint64_t exponent = kPrime - 2; exponent > 0; exponent /= 2) {
    if (exponent % 2 == 1) result = times_mod(result, a);
    a = times_mod(a, a);
  }
  return result;
}

/// The integer that `value` is in units of `step`; fails the check `exact` when it is none.
inline std::int64_t in_steps(double value, double step, bool& exact) {
  const double steps = value / step;
  if (!(std::fabs(steps) < 0x1p62) || std::trunc(steps) != steps) {
    exact = false;
    return 0;
  }
  return static_cast<std::int64_t>(steps);
}

/// Rank modulo 2^61 - 1 of a matrix of integers times `step`: never more than the rank. -1 if an entry is no such
/// number.
inline int rank_mod_prime(const ColumnMajor<double>& matrix, double step) {
  ColumnMajor<std::uint64_t> work(matrix.rows, matrix.cols);
  bool exact = true;
  for (std::size_t i = 0; i < work.data.size(); ++i) {
    const std::int64_t entry = in_steps(matrix.data[i], step, exact) % static_cast<std::int64_t>(kPrime);
    work.data[i] = entry < 0 ? kPrime - static_cast<std::uint64_t>(-entry) : static_cast<std::uint64_t>(entry);
  }
  if (!exact) return -1;
  std::size_t rank = 0;
  for (std::size_t col = 0; col < work.cols && rank < work.rows; ++col) {
    std::size_t pivot = rank;
    while (pivot < work.rows && work(pivot, col) == 0) ++pivot;
    if (pivot == work.rows) continue;
    for (std::size_t j = col; j < work.cols; ++j) std::swap(work(pivot, j), work(rank, j));
    const std::uint64_t inverse = inverse_mod(work(rank, col));
    for (std::size_t row = rank + 1; row < work.rows; ++row) {
      const std::uint64_t factor = times_mod(work(row, col), inverse);
      for (std::size_t j = col; j < work.cols; ++j) {
        work(row, j) = (work(row, j) + kPrime - times_mod(factor, work(rank, j))) % kPrime;
      }
    }
    ++rank;
  }
  return static_cast<int>(rank);
}

/// True when sign * (A - shift I) is positive definite, by a Cholesky factorization (without roots) in Quad.
inline bool definite_after_shift(const ColumnMajor<double>& A, Quad shift, int sign) {
  const std::size_t n = A.rows;
  ColumnMajor<Quad> work(n, n);
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t i = 0; i < n; ++i) work(i, j) = sign * (static_cast<Quad>(A(i, j)) - (i == j ? shift : Quad{0}));
  }
  for (std::size_t k = 0; k < n; ++k) {
    if (!(work(k, k) > 0)) return false;
    for (std::size_t i = k + 1; i < n; ++i) {
      const Quad factor = work(i, k) / work(k, k);
      for (std::size_t j = k + 1; j < n; ++j) work(i, j) -= factor * work(k, j);
    }
  }
  return true;
}

inline bool positive_definite(const ColumnMajor<double>& A) { return definite_after_shift(A, 0, 1); }

/// True when the smallest eigenvalue lies within `allowed` of `smallest`, and the largest within `allowed` of
/// `largest`.
inline bool spectrum_ends_at(const ColumnMajor<double>& A, double smallest, double largest, double allowed) {
  const Quad slack = allowed;
  return definite_after_shift(A, static_cast<Quad>(smallest) - slack, 1) &&
         !definite_after_shift(A, static_cast<Quad>(smallest) + slack, 1) &&
         definite_after_shift(A, static_cast<Quad>(largest) + slack, -1) &&
         !definite_after_shift(A, static_cast<Quad>(largest) - slack, -1);
}

inline bool symmetric(const ColumnMajor<double>& A) {
  for (std::size_t j = 0; j < A.cols; ++j) {
    for (std::size_t i = 0; i < j; ++i) {
      if (!(A(i, j) == A(j, i))) return false;
    }
  }
  return A.rows == A.cols;
}

/// Counts against equal expectations; several tables may be added up.
class ChiSquare {
 public:
  void add_uniform(const std::vector<int>& counts) {
    double total = 0;
    for (const int count : counts) total += count;
    const double expected = total / static_cast<double>(counts.size());
    for (const int count : counts) statistic_ += (count - expected) * (count - expected) / expected;
    degrees_ += static_cast<double>(counts.size()) - 1;
  }

  /// False when counts as uneven as these have a probability below 1e-6 (Wilson and Hilferty's approximation of the
  /// quantile). The seeds are fixed: a test that passes once passes always.
  bool plausible() const {
    const double normal_quantile = 4.7534;
    const double part = 2 / (9 * degrees_);
    const double root = 1 - part + normal_quantile * std::sqrt(part);
    return statistic_ < degrees_ * root * root * root;
  }

  double statistic() const { return statistic_; }
  double degrees() const { return degrees_; }

 private:
  double statistic_ = 0;
  double degrees_ = 0;
};

/// Counts of draws from {low, ..., high}, where `high` may differ between trials: one table for each.
class Tables {
 public:
  void add(std::int64_t value, std::int64_t low, std::int64_t high) {
    std::vector<int>& counts = counts_[{low, high}];
    counts.resize(static_cast<std::size_t>(high - low + 1));
    ++counts.at(static_cast<std::size_t>(value - low));
  }
  ChiSquare test() const {
    ChiSquare result;
    for (const auto& [range, counts] : counts_) {
      if (counts.size() > 1) result.add_uniform(counts);
    }
    return result;
  }

 private:
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<int>> counts_;
};

}  // namespace lcpbench::checks
