#include "study/evaluation/bounded_factors.h"

#include <algorithm>
#include <cmath>

#include "study/evaluation/at_isa_level.h"
#include "study/evaluation/bounded.h"

namespace lcpbench {
namespace {

/// Makes up for the rounding in H b: n^2 of its size for each triangular solution, as no number is below zero.
constexpr double kRoundedUp = 1 + 0x1p-20;
constexpr std::size_t kLargestOrder = std::size_t{1} << 14;
/// Of t |H 1|_1.
constexpr double kLargestShare = 0x1p-6;
/// An entry of H 1 that is larger is worth the inverse of U: it costs as much as the factors.
constexpr double kLargeBound = 0x1p17;

/// Added once to every sum, more than underflow may have lost in it.
double sum_of(std::span<const double> x) {
  double sum = bounded::kLost;
  for (const double value : x) sum += value;
  return sum * kRoundedUp;
}

/// A column to be eliminated: its entries, and those that are not zero divided by the pivot.
struct Pivoted {
  const double* entries;
  const std::uint32_t* rows;
  const double* values;
  std::size_t count;
};

/// Subtracts values[e] times the entries from each column rows[e] of the upper triangle of A. Where a quarter of them
/// is not zero, several at once cost no more than to pick those.
[[gnu::always_inline]] inline void subtract_all(const Pivoted& column, double* A, std::size_t n) {
  const double* __restrict const entries = column.entries;
  const bool many = column.count > 0 && 4 * column.count >= column.rows[column.count - 1];
  for (std::size_t e = 0; e < column.count; ++e) {
    double* __restrict const rest = A + column.rows[e] * n;
    const double value = column.values[e];
    if (many) {
      for (std::size_t k = 0; k <= column.rows[e]; ++k) rest[k] -= value * entries[k];
    } else {
      for (std::size_t k = 0; k <= e; ++k) rest[column.rows[k]] -= value * entries[column.rows[k]];
    }
  }
}

void subtract_products(const Pivoted& column, double* A, std::size_t n) { subtract_all(column, A, n); }

LCPBENCH_AVX2 void subtract_products_avx2(const Pivoted& column, double* A, std::size_t n) {
  subtract_all(column, A, n);
}

}  // namespace

void BoundedFactors::reserve(std::size_t matrices, std::size_t columns, std::size_t entries) {
  matrices_.reserve(matrices);
  for (auto* const by_column : {&inverse_pivots_, &of_ones_}) by_column->reserve(columns);
  end_.reserve(columns);
  rows_.reserve(entries);
  values_.reserve(entries);
}

bool BoundedFactors::add(std::span<const double> A, std::size_t n, double least) {
  if (n == 0 || n > kLargestOrder) return false;
  Factored matrix;
  matrix.first = end_.size();
  matrix.order = n;
  if (!eliminate(matrix, A, least)) {
    discard(matrix);
    return false;
  }
  // Each entry of A is a sum of at most n products and one pivot, less the rounding of as many products and
  // differences, of the inverse pivot and of the product with it: |E| <= gamma_(n + 6) |U| D |U'|, whose entries are at
  // most 4 and a few roundings. In solve() each of the two triangular solutions adds n roundings of an entry of |U|,
  // and the pivots three.
  const double order = static_cast<double>(n);
  matrix.residual = 4.5 * (3 * order + 12) * bounded::kRoundoff;
  of_ones_.resize(end_.size());
  bool found = find_bound(matrix, least);
  const auto ones = of_ones_.begin() + static_cast<std::ptrdiff_t>(matrix.first);
  if (!found || *std::max_element(ones, of_ones_.end()) > kLargeBound) {
    found = invert(matrix) && find_bound(matrix, least);
  }
  if (!found) {
    discard(matrix);
    return false;
  }
  matrices_.push_back(matrix);
  return true;
}

/// Finds the bound of |A^-1| 1. False where it does not prove A to have no eigenvalue below `least`.
bool BoundedFactors::find_bound(Factored& matrix, double least) {
  const std::span<double> ones = std::span(of_ones_).subspan(matrix.first, matrix.order);
  std::fill(ones.begin(), ones.end(), 1.0);
  compare(matrix, ones);
  const double rounding = 4.5 * (static_cast<double>(matrix.order) + 6) * bounded::kRoundoff;
  const double share = rounding * sum_of(ones);
  if (!(share < kLargestShare)) return false;
  matrix.rounding = rounding * kRoundedUp / (1 - share);
  double largest = 0;  // of |A^-1| in the maximum norm
  for (double& value : ones) {
    value *= (1 + share / (1 - share)) * kRoundedUp;
    largest = std::max(largest, value);
  }
  return largest * least < 1;
}

/// With Z = |U| |X| and s the largest sum of a column of g Z, each column of g Z (I - g Z)^-1 adds up to at most
/// s / (1 - s): an entry of |U^-1| exceeds that of |X| by at most so much of the largest one in its row.
bool BoundedFactors::invert(Factored& matrix) {
  const std::size_t n = matrix.order;
  matrix.inverse = inverses_.size();
  inverses_.resize(inverses_.size() + n * n, 0.0);
  double* const X = inverses_.data() + *matrix.inverse;
  std::vector<double> sums(n, 1.0), largest(n, 1.0);  // of the columns of |U|; in the rows of |X|
  const double rounding = (static_cast<double>(n) + 2) * bounded::kRoundoff * kRoundedUp;
  double share = 0;
  for (std::size_t j = 0; j < n; ++j) {
    const std::size_t column = matrix.first + (n - 1 - j);
    for (std::size_t e = begin(column); e < end_[column]; ++e) sums[j] += std::abs(values_[e]);
  }
  for (std::size_t k = 0; k < n; ++k) {
    double* const x = X + k * n;
    x[k] = 1;
    double of_column = 0;
    for (std::size_t j = k + 1; j-- > 0;) {
      if (x[j] == 0) continue;
      const std::size_t column = matrix.first + (n - 1 - j);
      for (std::size_t e = begin(column); e < end_[column]; ++e) x[rows_[e]] -= values_[e] * x[j];
      x[j] = std::abs(x[j]);
      of_column += sums[j] * x[j];
      largest[j] = std::max(largest[j], x[j]);
    }
    if (!(of_column * rounding < kLargestShare)) return false;  // nor is NaN
    share = std::max(share, of_column * rounding);
  }
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t j = 0; j < k; ++j) {
      X[k * n + j] = (X[k * n + j] + share / (1 - share) * largest[j]) * kRoundedUp + bounded::kLost;
    }
  }
  return true;
}

/// Appends the columns of U and the inverse pivots, the last one first: divides a column by its pivot, and subtracts
/// the outer product of the two from the columns before it. False, and what was appended is left to discard(), unless
/// all pivots are above `least`: in exact arithmetic none is below the least eigenvalue.
bool BoundedFactors::eliminate(const Factored& matrix, std::span<const double> A, double least) {
  static const auto subtract = at_isa_level(subtract_products, subtract_products_avx2);
  const std::size_t n = matrix.order;
  work_.assign(A.begin(), A.end());
  std::size_t used = rows_.size();
  rows_.resize(used + n * (n - 1) / 2);
  values_.resize(rows_.size());
  for (std::size_t j = n; j-- > 0; end_.push_back(used)) {
    const double* const last = work_.data() + j * n;
    if (!(last[j] > least)) return false;
    const double inverse = 1 / last[j];
    inverse_pivots_.push_back(inverse);
    const std::size_t first = used;
    for (std::size_t i = 0; i < j; ++i) {
      if (last[i] == 0) continue;
      rows_[used] = static_cast<std::uint32_t>(i);
      values_[used++] = last[i] * inverse;
    }
    subtract({last, rows_.data() + first, values_.data() + first, used - first}, work_.data(), n);
  }
  rows_.resize(used);
  values_.resize(used);
  return true;
}

void BoundedFactors::discard(const Factored& matrix) {
  end_.resize(matrix.first);
  inverse_pivots_.resize(matrix.first);
  of_ones_.resize(matrix.first);
  rows_.resize(begin(matrix.first));
  values_.resize(begin(matrix.first));
  if (matrix.inverse) inverses_.resize(*matrix.inverse);
}

void BoundedFactors::solve(std::size_t index, std::span<double> x) const {
  const Factored& matrix = matrices_[index];
  const std::uint32_t* const rows = rows_.data();
  const double* const values = values_.data();
  const std::size_t n = matrix.order;
  for (std::size_t j = n; j-- > 0;) {
    const std::size_t column = matrix.first + (n - 1 - j);
    const double known = x[j];
    if (known == 0) continue;
    for (std::size_t e = begin(column); e < end_[column]; ++e) x[rows[e]] -= values[e] * known;
    x[j] = known * inverse_pivots_[column];
  }
  for (std::size_t j = 0; j < n; ++j) {
    const std::size_t column = matrix.first + (n - 1 - j), end = end_[column];
    double even = 0, odd = 0;  // two sums, which do not wait for each other
    std::size_t e = begin(column);
    for (; e + 1 < end; e += 2) {
      even += values[e] * x[rows[e]];
      odd += values[e + 1] * x[rows[e + 1]];
    }
    if (e < end) even += values[e] * x[rows[e]];
    x[j] -= even + odd;
  }
}

/// b := H b, rounded. Sums of numbers >= 0.
void BoundedFactors::compare(const Factored& matrix, std::span<double> b) const {
  if (matrix.inverse) {
    multiply_by_inverse(matrix, b);
    return;
  }
  const std::uint32_t* const rows = rows_.data();
  const double* const values = values_.data();
  const std::size_t n = matrix.order;
  for (std::size_t j = n; j-- > 0;) {
    const std::size_t column = matrix.first + (n - 1 - j);
    const double known = b[j];
    for (std::size_t e = begin(column); e < end_[column]; ++e) b[rows[e]] += std::abs(values[e]) * known;
    b[j] = known * inverse_pivots_[column];
  }
  for (std::size_t j = 0; j < n; ++j) {
    const std::size_t column = matrix.first + (n - 1 - j);
    double rest = b[j];
    for (std::size_t e = begin(column); e < end_[column]; ++e) rest += std::abs(values[e]) * b[rows[e]];
    b[j] = rest;
  }
}

/// The same with |U^-1|.
void BoundedFactors::multiply_by_inverse(const Factored& matrix, std::span<double> b) const {
  const std::size_t n = matrix.order;
  const double* const inverse = inverses_.data() + *matrix.inverse;
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t i = 0; i < j; ++i) b[i] += inverse[j * n + i] * b[j];
  }
  for (std::size_t j = 0; j < n; ++j) b[j] *= inverse_pivots_[matrix.first + (n - 1 - j)];
  for (std::size_t j = n; j-- > 0;) {
    double sum = b[j];
    for (std::size_t i = 0; i < j; ++i) sum += inverse[j * n + i] * b[i];
    b[j] = sum;
  }
}

void BoundedFactors::bound(std::size_t index, std::span<double> b) const {
  const Factored& matrix = matrices_[index];
  compare(matrix, b);
  const double of_rounding = matrix.rounding * sum_of(b);
  const std::span<const double> ones = bound_of_ones(index);
  for (std::size_t i = 0; i < b.size(); ++i) b[i] = (b[i] + of_rounding * ones[i]) * kRoundedUp + bounded::kLost;
}

}  // namespace lcpbench
