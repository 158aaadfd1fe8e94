#include "generators/paper/spectrum.h"

#include <algorithm>
#include <bit>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <stdexcept>

static_assert(FLT_EVAL_METHOD == 0, "doubles must be computed as doubles: build for SSE2, not for x87");
#ifdef __FAST_MATH__
#error "value-changing optimisations would change the problems"
#endif

namespace lcpbench {
namespace {

constexpr double kUnitRoundoff = 0x1p-53;
constexpr int kMaxSweeps = 60;

double power_of_two(int exponent) { return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52); }

double dot(const double* a, const double* b, std::size_t n) {
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

void rotate(double* a, double* b, std::size_t n, double cosine, double sine) {
  for (std::size_t i = 0; i < n; ++i) {
    const double first = a[i];
    const double second = b[i];
    a[i] = cosine * first - sine * second;
    b[i] = sine * first + cosine * second;
  }
}

// Makes columns p and q orthogonal and keeps their squared lengths up to date; false if they are orthogonal already, to
// rounding.
bool orthogonalise(ColumnMajor<double>& Y, std::vector<double>& squares, std::size_t p, std::size_t q) {
  double* const a = Y.column(p);
  double* const b = Y.column(q);
  const double product = dot(a, b, Y.rows);
  const double tolerance = static_cast<double>(Y.rows) * kUnitRoundoff;
  if (std::fabs(product) <= tolerance * std::sqrt(squares[p] * squares[q])) return false;
  const double cotangent = (squares[q] - squares[p]) / (2 * product);
  const double tangent = (cotangent >= 0 ? 1.0 : -1.0) / (std::fabs(cotangent) + std::sqrt(1 + cotangent * cotangent));
  const double cosine = 1 / std::sqrt(1 + tangent * tangent);
  rotate(a, b, Y.rows, cosine, cosine * tangent);
  squares[p] = std::max(0.0, squares[p] - tangent * product);
  squares[q] = std::max(0.0, squares[q] + tangent * product);
  return true;
}

std::vector<double> squared_lengths(const ColumnMajor<double>& Y) {
  std::vector<double> squares(Y.cols);
  for (std::size_t j = 0; j < Y.cols; ++j) squares[j] = dot(Y.column(j), Y.column(j), Y.rows);
  return squares;
}

// Lengths are measured anew in each sweep, for a short column's updates lose digits to a long one's.
bool sweep(ColumnMajor<double>& Y) {
  std::vector<double> squares = squared_lengths(Y);
  bool rotated = false;
  for (std::size_t p = 0; p + 1 < Y.cols; ++p) {
    for (std::size_t q = p + 1; q < Y.cols; ++q) {
      if (orthogonalise(Y, squares, p, q)) rotated = true;
    }
  }
  return rotated;
}

}  // namespace

double portable_log2(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  int exponent = static_cast<int>(bits >> 52) - 1023;
  double mantissa = std::bit_cast<double>((bits & 0xfffffffffffffU) | 0x3ff0000000000000U);
  if (mantissa > 0x1.6a09e667f3bcdp+0) {
    mantissa /= 2;
    ++exponent;
  }
  // log(m) = 2 artanh(s); |s| < 0.172, so the term s^25/25 is below 2^-65 of the first.
  const double s = (mantissa - 1) / (mantissa + 1);
  const double square = s * s;
  double series = 0;
  for (int odd = 23; odd >= 3; odd -= 2) series = (series + 1.0 / odd) * square;
  const double two_over_ln2 = 0x1.71547652b82fep+1;
  return static_cast<double>(exponent) + two_over_ln2 * (s + s * series);
}

double portable_exp2(double x) {
  const int whole = static_cast<int>(x + (x >= 0 ? 0.5 : -0.5));
  const double ln2 = 0x1.62e42fefa39efp-1;
  const double rest = (x - whole) * ln2;
  // |rest| < 0.35: the term of degree 15 is below 2^-60.
  double series = 1;
  for (int degree = 15; degree >= 1; --degree) series = 1 + series * rest / degree;
  return series * power_of_two(whole);
}

ColumnMajor<double> weighted_outer_sum(const ColumnMajor<double>& X, const std::vector<double>& weights) {
  ColumnMajor<double> sum(X.rows, X.rows);
  for (std::size_t k = 0; k < X.cols; ++k) {
    const double* const x = X.column(k);
    for (std::size_t j = 0; j < X.rows; ++j) {
      const double scaled = weights[k] * x[j];
      for (std::size_t i = 0; i <= j; ++i) sum(i, j) += x[i] * scaled;
    }
  }
  for (std::size_t j = 0; j < X.rows; ++j) {
    for (std::size_t i = 0; i < j; ++i) sum(j, i) = sum(i, j);
  }
  return sum;
}

bool safely_positive_definite(const ColumnMajor<double>& A) {
  const std::size_t n = A.rows;
  const double order = static_cast<double>(n);
  const double kept = 1 - 2 * order * (order + 2) * kUnitRoundoff;
  ColumnMajor<double> factor(n, n);  // upper triangular R, A - c diag(A) = R'R
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t i = 0; i < j; ++i) {
      factor(i, j) = (A(i, j) - dot(factor.column(i), factor.column(j), i)) / factor(i, i);
    }
    const double pivot = A(j, j) * kept - dot(factor.column(j), factor.column(j), j);
    if (!(pivot > 0)) return false;
    factor(j, j) = std::sqrt(pivot);
  }
  return true;
}

Eigensystem spectrum_of_square(ColumnMajor<double> Y) {
  int sweeps = 0;
  while (sweep(Y)) {
    if (++sweeps == kMaxSweeps) throw std::logic_error("Jacobi rotations did not converge");
  }
  const std::size_t n = Y.cols;
  const std::vector<double> squares = squared_lengths(Y);
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return squares[a] < squares[b]; });

  Eigensystem spectrum;
  spectrum.vectors = ColumnMajor<double>(n, n);
  for (std::size_t j = 0; j < n; ++j) {
    const double norm = std::sqrt(squares[order[j]]);
    spectrum.values.push_back(squares[order[j]]);
    for (std::size_t i = 0; i < n; ++i) spectrum.vectors(i, j) = Y(i, order[j]) / norm;
  }
  return spectrum;
}

std::vector<double> map_spectrum(const std::vector<double>& values, double condition, SpectrumMap map) {
  const std::size_t n = values.size();
  const auto position = [&](std::size_t i) {
    if (map == SpectrumMap::kLogLinear) return portable_log2(values[i]);
    return map == SpectrumMap::kLinear ? values[i] : static_cast<double>(i);
  };
  const double low = position(0);
  const double span = position(n - 1) - low;
  const double log_condition = portable_log2(condition);
  std::vector<double> mapped(n, 1.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double share = span > 0 ? (position(i) - low) / span : 0;
    mapped[i] = map == SpectrumMap::kLinear ? 1 + share * (condition - 1) : portable_exp2(share * log_condition);
    mapped[i] = std::clamp(mapped[i], 1.0, condition);
  }
  mapped[n - 1] = condition;
  return mapped;
}

}  // namespace lcpbench
