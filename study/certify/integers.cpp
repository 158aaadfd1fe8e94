#include "study/certify/integers.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>

#include <flint/nmod_mat.h>

namespace lcpbench::exact {
namespace {

constexpr mp_limb_t kPrime = 9223372036854775783U;  // 2^63 - 25
constexpr int kDoubleBits = 53;
constexpr slong kSmallestExponent = -1074;  // of the smallest positive double

// What operations take, in steps of Deadline: one on a number of a word; a product of entries, and of words in them.
constexpr double kOperation = 0.0005;
constexpr double kProduct = 0.0006;

double bits_of(const IntegerMatrix& a) { return static_cast<double>(std::abs(fmpz_mat_max_bits(a.get()))); }

}  // namespace

IntegerMatrix operator*(const IntegerMatrix& a, const IntegerMatrix& b) {
  IntegerMatrix c(a.rows(), b.cols());
  fmpz_mat_mul(c.get(), a.get(), b.get());
  return c;
}

IntegerMatrix transposed(const IntegerMatrix& a) {
  IntegerMatrix t(a.cols(), a.rows());
  fmpz_mat_transpose(t.get(), a.get());
  return t;
}

IntegerMatrix part(const IntegerMatrix& a, const std::vector<Index>& rows, const std::vector<Index>& cols) {
  IntegerMatrix p(std::ssize(rows), std::ssize(cols));
  for (Index i = 0; i < p.rows(); ++i) {
    for (Index j = 0; j < p.cols(); ++j) fmpz_set(p(i, j), a(rows[index(i)], cols[index(j)]));
  }
  return p;
}

std::vector<Index> range(Index begin, Index end) {
  std::vector<Index> indices(index(end - begin));
  std::iota(indices.begin(), indices.end(), begin);
  return indices;
}

std::vector<Index> independent_columns(const IntegerMatrix& A, const Deadline& deadline) {
  const auto rows = static_cast<double>(A.rows());
  deadline.require(kOperation * rows * static_cast<double>(A.cols()) * (rows + bits_of(A) / 64));
  nmod_mat_t residues;
  nmod_mat_init(residues, A.rows(), A.cols(), kPrime);
  fmpz_mat_get_nmod_mat(residues, A.get());
  const slong rank = nmod_mat_rref(residues);
  std::vector<Index> independent;
  for (Index j = 0; std::ssize(independent) < rank; ++j) {
    if (nmod_mat_entry(residues, std::ssize(independent), j) != 0) independent.push_back(j);
  }
  nmod_mat_clear(residues);
  return independent;
}

void solve(IntegerMatrix A, const IntegerMatrix& B, IntegerMatrix& X, Integer& denominator, const Deadline& deadline) {
  const Index n = A.rows();
  // Powers of two that a whole column has go to the unit of its unknown.
  std::vector<slong> shifts(index(n), std::numeric_limits<slong>::max());
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      if (A.is_zero(i, j)) continue;
      shifts[index(j)] = std::min(shifts[index(j)], static_cast<slong>(fmpz_val2(A(i, j))));
    }
  }
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) fmpz_tdiv_q_2exp(A(i, j), A(i, j), static_cast<ulong>(shifts[index(j)]));
  }
  // Each of the digits of the solution takes two products of a matrix and a column for each right-hand side.
  const double order = static_cast<double>(n);
  const double words = 1 + bits_of(A) / 64;
  const double digits = 1 + 2 * order * words + bits_of(B) / 64;
  deadline.require(order * order * (kOperation * order + kProduct * words * digits * static_cast<double>(B.cols())));
  X = IntegerMatrix(n, B.cols());
  fmpz_one(denominator.get());
  if (n == 0 || fmpz_mat_is_zero(B.get()) != 0) return;
  fmpz_mat_solve(X.get(), denominator.get(), A.get(), B.get());
  if (fmpz_sgn(denominator.get()) < 0) {
    fmpz_neg(denominator.get(), denominator.get());
    fmpz_mat_neg(X.get(), X.get());
  }
  const slong most = *std::max_element(shifts.begin(), shifts.end());
  fmpz_mul_2exp(denominator.get(), denominator.get(), static_cast<ulong>(most));
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < X.cols(); ++j) fmpz_mul_2exp(X(i, j), X(i, j), static_cast<ulong>(most - shifts[index(i)]));
  }
}

IntegerMatrix determined(const IntegerMatrix& A, const IntegerMatrix& b, Integer& denominator,
                         const Deadline& deadline) {
  const std::vector<Index> columns = independent_columns(A, deadline);
  std::vector<Index> rows = range(0, A.rows());
  if (columns.size() < rows.size()) rows = independent_columns(transposed(part(A, rows, columns)), deadline);
  IntegerMatrix found;
  solve(part(A, rows, columns), part(b, rows, {0}), found, denominator, deadline);
  IntegerMatrix x(A.cols());
  for (Index j = 0; j < found.rows(); ++j) fmpz_swap(x(columns[index(j)]), found(j));
  return x;
}

Dyadic to_dyadic(const Matrix& a) {
  Dyadic result{IntegerMatrix(a.rows(), a.cols()), std::numeric_limits<int>::max()};
  for (const double value : a.reshaped()) {
    if (value != 0) result.exponent = std::min(result.exponent, slong{std::ilogb(value)} - (kDoubleBits - 1));
  }
  if (result.exponent == std::numeric_limits<int>::max()) result.exponent = 0;
  for (Index j = 0; j < a.cols(); ++j) {
    for (Index i = 0; i < a.rows(); ++i) fmpz_set_d_2exp(result.m(i, j), a(i, j), -result.exponent);
  }
  return result;
}

Dyadic operator*(const Dyadic& a, const Dyadic& b) { return {a.m * b.m, a.exponent + b.exponent}; }

Dyadic operator+(const Dyadic& a, const Dyadic& b) {
  const Dyadic both = beside(a, b);
  const std::vector<Index> rows = range(0, a.m.rows());
  Dyadic sum{part(both.m, rows, range(0, a.m.cols())), both.exponent};
  fmpz_mat_add(sum.m.get(), sum.m.get(), part(both.m, rows, range(a.m.cols(), both.m.cols())).get());
  return sum;
}

Dyadic operator-(Dyadic a) {
  fmpz_mat_neg(a.m.get(), a.m.get());
  return a;
}

Dyadic transposed(const Dyadic& a) { return {transposed(a.m), a.exponent}; }

Dyadic beside(std::initializer_list<const Dyadic*> matrices) {
  constexpr slong kNone = std::numeric_limits<slong>::max();
  Index columns = 0;
  slong exponent = kNone;
  for (const Dyadic* a : matrices) {
    columns += a->m.cols();
    if (fmpz_mat_is_zero(a->m.get()) == 0) exponent = std::min(exponent, a->exponent);
  }
  Dyadic result{IntegerMatrix((*matrices.begin())->m.rows(), columns), exponent == kNone ? 0 : exponent};
  Index column = 0;
  for (const Dyadic* a : matrices) {
    for (Index j = 0; j < a->m.cols(); ++j, ++column) {
      for (Index i = 0; i < a->m.rows(); ++i) {
        if (a->m.is_zero(i, j)) continue;
        fmpz_mul_2exp(result.m(i, column), a->m(i, j), static_cast<ulong>(a->exponent - result.exponent));
      }
    }
  }
  return result;
}

double rounded(const fmpz* numerator, const Integer& denominator) {
  if (fmpz_sgn(numerator) == 0) return 0;
  Integer a;
  Integer b = denominator;
  fmpz_abs(a.get(), numerator);
  // The quotient in units of 2^unit: 53 bits, then one for the half and one that says whether anything is left. Below
  // the normal numbers there are fewer before these two.
  const slong bits = static_cast<slong>(fmpz_bits(a.get())) - static_cast<slong>(fmpz_bits(b.get()));
  const slong unit = std::max(bits - kDoubleBits - 2, kSmallestExponent - 2);
  if (unit > std::numeric_limits<double>::max_exponent) return fmpz_sgn(numerator) * HUGE_VAL;
  Integer& scaled = unit > 0 ? b : a;
  fmpz_mul_2exp(scaled.get(), scaled.get(), static_cast<ulong>(std::abs(unit)));
  Integer rest;
  fmpz_fdiv_qr(a.get(), rest.get(), a.get(), b.get());
  if (fmpz_is_zero(rest.get()) == 0 && fmpz_is_even(a.get()) != 0) fmpz_add_ui(a.get(), a.get(), 1);
  return fmpz_sgn(numerator) * std::ldexp(static_cast<double>(fmpz_get_si(a.get())), static_cast<int>(unit));
}

std::string text(const fmpz* value) {
  std::string digits(fmpz_sizeinbase(value, 10) + 2, '\0');
  fmpz_get_str(digits.data(), 10, value);
  digits.resize(digits.find('\0'));
  return digits;
}

}  // namespace lcpbench::exact
