#include "tests/attack/exact.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lcpbench::attack {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

/// The least exponent of the nonzero entries; 0 where there is none.
long least_exponent(const std::vector<Dyadic>& entries) {
  long least = std::numeric_limits<long>::max();
  for (const Dyadic& x : entries) {
    if (x.sign() != 0) least = std::min(least, x.exponent());
  }
  return least == std::numeric_limits<long>::max() ? 0 : least;
}

IntegerMatrix integers(const DyadicMatrix& A, long exponent) {
  IntegerMatrix result(A.rows, A.cols);
  for (std::size_t k = 0; k < A.entries.size(); ++k) result.entries[k] = A.entries[k].over(exponent);
  return result;
}

}  // namespace

Dyadic::Dyadic(double x) {
  if (x == 0) return;
  int exponent = 0;
  auto numerator = static_cast<long long>(std::ldexp(std::frexp(x, &exponent), 53));
  exponent_ = exponent - 53;
  while (numerator % 2 == 0) {
    numerator /= 2;
    ++exponent_;
  }
  numerator_ = numerator;
}

Integer Dyadic::over(long exponent) const {
  if (sign() == 0) return 0;
  if (exponent_ >= exponent) return numerator_ << static_cast<unsigned long>(exponent_ - exponent);
  return numerator_ / (Integer(1) << static_cast<unsigned long>(exponent - exponent_));
}

Dyadic operator+(const Dyadic& a, const Dyadic& b) {
  if (a.sign() == 0) return b;
  if (b.sign() == 0) return a;
  const long exponent = std::min(a.exponent_, b.exponent_);
  return {a.over(exponent) + b.over(exponent), exponent};
}

Dyadic operator-(const Dyadic& a, const Dyadic& b) { return a + (-b); }

Dyadic operator*(const Dyadic& a, const Dyadic& b) {
  if (a.sign() == 0 || b.sign() == 0) return {};
  return {a.numerator_ * b.numerator_, a.exponent_ + b.exponent_};
}

Dyadic abs(const Dyadic& a) { return a.sign() < 0 ? -a : a; }
const Dyadic& min(const Dyadic& a, const Dyadic& b) { return b < a ? b : a; }
const Dyadic& max(const Dyadic& a, const Dyadic& b) { return a < b ? b : a; }

double quotient(const Dyadic& a, const Dyadic& b) {
  if (a.sign() == 0) return 0;
  if (b.sign() == 0) return std::numeric_limits<double>::infinity();
  signed long a_exponent = 0;
  signed long b_exponent = 0;
  const double x = mpz_get_d_2exp(&a_exponent, a.numerator().backend().data());
  const double y = mpz_get_d_2exp(&b_exponent, b.numerator().backend().data());
  const long exponent = std::clamp(a_exponent + a.exponent() - b_exponent - b.exponent(), -5000L, 5000L);
  return std::ldexp(x / y, static_cast<int>(exponent));
}

DyadicMatrix exact(const Matrix& A) {
  DyadicMatrix result(A.rows(), A.cols());
  for (Index i = 0; i < A.rows(); ++i) {
    for (Index j = 0; j < A.cols(); ++j) result(i, j) = Dyadic(A(i, j));
  }
  return result;
}

DyadicVector exact(const Vector& x) {
  DyadicVector result;
  for (const double value : x) result.emplace_back(value);
  return result;
}

DyadicMatrix product(const DyadicMatrix& A, const DyadicMatrix& B) {
  DyadicMatrix result(A.rows, B.cols);
  for (Index i = 0; i < A.rows; ++i) {
    for (Index j = 0; j < B.cols; ++j) {
      for (Index k = 0; k < A.cols; ++k) result(i, j) = result(i, j) + A(i, k) * B(k, j);
    }
  }
  return result;
}

DyadicMatrix transposed(const DyadicMatrix& A) {
  DyadicMatrix result(A.cols, A.rows);
  for (Index i = 0; i < A.rows; ++i) {
    for (Index j = 0; j < A.cols; ++j) result(j, i) = A(i, j);
  }
  return result;
}

DyadicVector product(const DyadicMatrix& A, const DyadicVector& x) {
  DyadicVector result(at(A.rows));
  for (Index i = 0; i < A.rows; ++i) {
    for (Index j = 0; j < A.cols; ++j) result[at(i)] = result[at(i)] + A(i, j) * x[at(j)];
  }
  return result;
}

Dyadic dot(const DyadicVector& a, const DyadicVector& b) {
  Dyadic sum;
  for (std::size_t i = 0; i < a.size(); ++i) sum = sum + a[i] * b[i];
  return sum;
}

std::optional<Inverse> inverse(const DyadicMatrix& A) {
  const Index n = A.rows;
  const long exponent = least_exponent(A.entries);
  const IntegerMatrix start = integers(A, exponent);
  IntegerMatrix work(n, 2 * n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) work(i, j) = start(i, j);
    work(i, n + i) = 1;
  }
  Integer previous = 1;
  for (Index k = 0; k < n; ++k) {
    Index pivot = k;
    while (pivot < n && work(pivot, k) == 0) ++pivot;
    if (pivot == n) return std::nullopt;
    for (Index j = 0; j < 2 * n && pivot != k; ++j) std::swap(work(k, j), work(pivot, j));
    for (Index i = 0; i < n; ++i) {
      if (i == k) continue;
      const Integer factor = work(i, k);
      for (Index j = 0; j < 2 * n; ++j) work(i, j) = (work(k, k) * work(i, j) - factor * work(k, j)) / previous;
    }
    previous = work(k, k);
  }
  const int sign = previous < 0 ? -1 : 1;
  Inverse result{DyadicMatrix(n, n), Dyadic(Integer(previous * sign), 0)};
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) result.numerator(i, j) = Dyadic(Integer(work(i, n + j) * sign), -exponent);
  }
  return result;
}

bool positive_definite(const DyadicMatrix& A) {
  IntegerMatrix work = integers(A, least_exponent(A.entries));
  Integer previous = 1;
  for (Index k = 0; k < work.rows; ++k) {
    if (work(k, k) <= 0) return false;
    for (Index i = k + 1; i < work.rows; ++i) {
      for (Index j = k + 1; j < work.cols; ++j) {
        work(i, j) = (work(k, k) * work(i, j) - work(i, k) * work(k, j)) / previous;
      }
    }
    previous = work(k, k);
  }
  return true;
}

bool positive_semidefinite(const DyadicMatrix& A) {
  IntegerMatrix work = integers(A, least_exponent(A.entries));
  std::vector<bool> used(at(work.rows), false);
  Integer previous = 1;
  for (;;) {
    Index k = -1;
    for (Index i = 0; i < work.rows; ++i) {
      if (used[at(i)]) continue;
      if (work(i, i) < 0) return false;
      if (work(i, i) > 0) k = i;
    }
    if (k < 0) break;
    used[at(k)] = true;
    const IntegerMatrix before = work;
    for (Index i = 0; i < work.rows; ++i) {
      for (Index j = 0; j < work.cols; ++j) {
        if (used[at(i)] || used[at(j)]) continue;
        work(i, j) = (before(k, k) * before(i, j) - before(i, k) * before(k, j)) / previous;
      }
    }
    previous = before(k, k);
  }
  for (Index i = 0; i < work.rows; ++i) {
    for (Index j = 0; j < work.cols; ++j) {
      if (!used[at(i)] && !used[at(j)] && work(i, j) != 0) return false;
    }
  }
  return true;
}

std::vector<Index> independent_columns(const DyadicMatrix& A) {
  IntegerMatrix work = integers(A, least_exponent(A.entries));
  std::vector<Index> columns;
  Integer previous = 1;
  Index rank = 0;
  for (Index k = 0; k < work.cols && rank < work.rows; ++k) {
    Index pivot = rank;
    while (pivot < work.rows && work(pivot, k) == 0) ++pivot;
    if (pivot == work.rows) continue;
    for (Index j = 0; j < work.cols && pivot != rank; ++j) std::swap(work(rank, j), work(pivot, j));
    for (Index i = rank + 1; i < work.rows; ++i) {
      const Integer factor = work(i, k);
      for (Index j = k; j < work.cols; ++j) {
        work(i, j) = (work(rank, k) * work(i, j) - factor * work(rank, j)) / previous;
      }
    }
    previous = work(rank, k);
    columns.push_back(k);
    ++rank;
  }
  return columns;
}

Inequalities::Inequalities(const DyadicMatrix& rows) : row_count_(rows.rows), column_count_(rows.cols - 1) {
  column_exponent_.assign(at(rows.cols), 0);
  for (Index j = 1; j < rows.cols; ++j) {
    std::vector<Dyadic> column;
    for (Index i = 0; i < rows.rows; ++i) column.push_back(rows(i, j));
    column_exponent_[at(j)] = least_exponent(column);
  }
  for (Index i = 0; i < rows.rows; ++i) {
    std::vector<Dyadic> row;
    for (Index j = 0; j < rows.cols; ++j) {
      row.emplace_back(rows(i, j).numerator(), rows(i, j).exponent() - column_exponent_[at(j)]);
    }
    const long exponent = least_exponent(row);
    Integers& scaled = dictionary_.emplace_back();
    for (const Dyadic& x : row) scaled.push_back(x.over(exponent));
    row_exponent_.push_back(exponent);
    basic_.push_back(i);
  }
  for (Index j = 0; j < column_count_; ++j) nonbasic_.push_back(row_count_ + j);
}

void Inequalities::pivot(std::size_t row, std::size_t column) {
  const Integer divisor = denominator_;
  const Integer p = entry(row, column);
  const Integers pivot_row = dictionary_[row];
  for (std::size_t i = 0; i < dictionary_.size(); ++i) {
    if (i == row) continue;
    const Integer factor = entry(i, column);
    for (std::size_t j = 0; j < pivot_row.size(); ++j) {
      if (j == column + 1) continue;
      dictionary_[i][j] = (p * dictionary_[i][j] - factor * pivot_row[j]) / divisor;
    }
  }
  for (std::size_t j = 0; j < pivot_row.size(); ++j) dictionary_[row][j] = -pivot_row[j];
  entry(row, column) = divisor;
  denominator_ = p;
  std::swap(basic_[row], nonbasic_[column]);
  if (p > 0) return;
  denominator_ = -p;
  for (Integers& numbers : dictionary_) {
    for (Integer& number : numbers) number = -number;
  }
}

bool Inequalities::impose(Index variable) {
  auto column = static_cast<std::size_t>(std::find(nonbasic_.begin(), nonbasic_.end(), variable) - nonbasic_.begin());
  if (column == nonbasic_.size()) {
    const auto found = std::find(basic_.begin(), basic_.end(), variable);
    if (found == basic_.end()) return true;  // is zero already
    const auto row = static_cast<std::size_t>(found - basic_.begin());
    column = 0;
    while (column < nonbasic_.size() && entry(row, column) == 0) ++column;
    if (column == nonbasic_.size()) {
      if (dictionary_[row].front() != 0) return false;
      dictionary_.erase(dictionary_.begin() + static_cast<std::ptrdiff_t>(row));
      basic_.erase(found);
      return true;
    }
    pivot(row, column);
  }
  nonbasic_.erase(nonbasic_.begin() + static_cast<std::ptrdiff_t>(column));
  for (Integers& numbers : dictionary_) numbers.erase(numbers.begin() + static_cast<std::ptrdiff_t>(column) + 1);
  return true;
}

bool Inequalities::feasible() {
  for (;;) {
    std::size_t row = basic_.size();
    for (std::size_t i = 0; i < basic_.size(); ++i) {
      if (dictionary_[i].front() < 0 && (row == basic_.size() || basic_[i] < basic_[row])) row = i;
    }
    if (row == basic_.size()) return true;
    std::size_t column = nonbasic_.size();
    for (std::size_t j = 0; j < nonbasic_.size(); ++j) {
      if (entry(row, j) > 0 && (column == nonbasic_.size() || nonbasic_[j] < nonbasic_[column])) column = j;
    }
    if (column == nonbasic_.size()) {
      contradicting_row_ = row;
      return false;
    }
    pivot(row, column);
  }
}

int Inequalities::sign(Index variable) const {
  const auto found = std::find(basic_.begin(), basic_.end(), variable);
  return found == basic_.end() ? 0 : dictionary_[static_cast<std::size_t>(found - basic_.begin())].front().sign();
}

Dyadic Inequalities::value(Index variable) const {
  const auto found = std::find(basic_.begin(), basic_.end(), variable);
  if (found == basic_.end()) return {};
  const Integer& scaled = dictionary_[static_cast<std::size_t>(found - basic_.begin())].front();
  const bool is_row = variable < row_count_;
  return {scaled, is_row ? row_exponent_[at(variable)] : -column_exponent_[at(variable - row_count_ + 1)]};
}

DyadicVector Inequalities::contradiction() const {
  Integers u(at(row_count_), Integer(0));
  const Integers& row = dictionary_[contradicting_row_];
  if (basic_[contradicting_row_] < row_count_) u[at(basic_[contradicting_row_])] = denominator_;
  for (std::size_t j = 0; j < nonbasic_.size(); ++j) {
    if (nonbasic_[j] < row_count_) u[at(nonbasic_[j])] = -row[j + 1];
  }
  Integer divisor = 0;
  for (const Integer& x : u) divisor = boost::multiprecision::gcd(divisor, x);
  DyadicVector result;
  for (std::size_t i = 0; i < u.size(); ++i) {
    result.emplace_back(divisor == 0 ? u[i] : Integer(u[i] / divisor), -row_exponent_[i]);
  }
  return result;
}

}  // namespace lcpbench::attack
