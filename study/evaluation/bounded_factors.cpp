#include "study/evaluation/bounded_factors.h"

#include <algorithm>
#include <cmath>

#include "study/evaluation/bounded.h"

namespace lcpbench {
namespace {

/// Makes up for the rounding in H b: n^2 of its size for each triangular solution, as no number is below zero.
constexpr double kRoundedUp = 1 + 0x1p-20;
constexpr std::size_t kLargestOrder = std::size_t{1} << 14;
/// Of t |H 1|_1.
constexpr double kLargestShare = 0x1p-6;

/// Added once to every sum, more than underflow may have lost in it.
double sum_of(std::span<const double> x) {
  double sum = bounded::kLost;
  for (const double value : x) sum += value;
  return sum * kRoundedUp;
}

}  // namespace

bool BoundedFactors::add(std::span<const double> A, std::size_t n, double least) {
  if (n == 0 || n > kLargestOrder) return false;
  work_.assign(A.begin(), A.end());
  column_.resize(n);
  Factored matrix{.first = end_.size(), .order = n};
  const std::size_t nonzeros = rows_.size() + n * (n - 1) / 2;
  rows_.reserve(nonzeros);
  values_.reserve(nonzeros);
  for (std::size_t j = n; j-- > 0;) {
    const double pivot = work_[j * n + j];
    if (!(pivot > least)) {  // the least eigenvalue is no larger than any pivot
      discard(matrix);
      return false;
    }
    inverse_pivots_.push_back(1 / pivot);
    eliminate(j, n);
    end_.push_back(rows_.size());
  }
  // Each entry of A is a sum of at most n products and one pivot, less the rounding of as many products and differences,
  // of the inverse pivot and of the product with it: |E| <= gamma_(n + 6) |U| D |U'|, whose entries are at most 4 and a
  // few roundings. In solve() each of the two triangular solutions adds n roundings of an entry of |U|, and the pivots
  // three.
  const double order = static_cast<double>(n);
  matrix.rounding = 4.5 * (order + 6) * bounded::kRoundoff;
  matrix.residual = 4.5 * (3 * order + 12) * bounded::kRoundoff;
  of_ones_.resize(end_.size());
  const std::span<double> ones = std::span(of_ones_).subspan(matrix.first, n);
  std::fill(ones.begin(), ones.end(), 1.0);
  compare(matrix, ones);
  const double share = matrix.rounding * sum_of(ones);
  if (!(share < kLargestShare)) {
    discard(matrix);
    return false;
  }
  matrix.rounding *= kRoundedUp / (1 - share);
  double largest = 0;  // of |A^-1| in the maximum norm
  for (double& value : ones) {
    value *= (1 + share / (1 - share)) * kRoundedUp;
    largest = std::max(largest, value);
  }
  if (!(largest * least < 1)) {
    discard(matrix);
    return false;
  }
  matrices_.push_back(matrix);
  return true;
}

/// Of what is left: divides a column by its pivot, and subtracts their product from the columns before it.
void BoundedFactors::eliminate(std::size_t j, std::size_t n) {
  const double* const last = work_.data() + j * n;
  const double inverse = inverse_pivots_.back();
  const std::size_t first = rows_.size();
  double* const column = column_.data();
  std::size_t count = 0;
  for (std::size_t i = 0; i < j; ++i) {
    if (last[i] == 0) continue;
    column[count++] = last[i];
    rows_.push_back(static_cast<std::uint32_t>(i));
    values_.push_back(last[i] * inverse);
  }
  const std::uint32_t* const rows = rows_.data() + first;
  const double* const values = values_.data() + first;
  for (std::size_t e = 0; e < count; ++e) {
    double* const rest = work_.data() + rows[e] * n;
    const double value = values[e];
    if (count == j) {
      for (std::size_t k = 0; k <= e; ++k) rest[k] -= value * column[k];
    } else {
      for (std::size_t k = 0; k <= e; ++k) rest[rows[k]] -= value * column[k];
    }
  }
}

void BoundedFactors::discard(const Factored& matrix) {
  end_.resize(matrix.first);
  inverse_pivots_.resize(matrix.first);
  of_ones_.resize(matrix.first);
  rows_.resize(begin(matrix.first));
  values_.resize(begin(matrix.first));
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
    const std::size_t column = matrix.first + (n - 1 - j);
    double rest = x[j];
    for (std::size_t e = begin(column); e < end_[column]; ++e) rest -= values[e] * x[rows[e]];
    x[j] = rest;
  }
}

/// b := H b, rounded. Sums of numbers >= 0.
void BoundedFactors::compare(const Factored& matrix, std::span<double> b) const {
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

void BoundedFactors::bound(std::size_t index, std::span<double> b) const {
  const Factored& matrix = matrices_[index];
  compare(matrix, b);
  const double of_rounding = matrix.rounding * sum_of(b);
  const std::span<const double> ones = bound_of_ones(index);
  for (std::size_t i = 0; i < b.size(); ++i) b[i] = (b[i] + of_rounding * ones[i]) * kRoundedUp + bounded::kLost;
}

}  // namespace lcpbench
