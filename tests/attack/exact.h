#pragma once

#include <optional>
#include <vector>

#include <boost/multiprecision/gmp.hpp>

#include "core/types.h"

/// Exact arithmetic of the attack. It shares no code with what it judges: neither with study/certify nor with native/.
namespace lcpbench::attack {

using Integer = boost::multiprecision::number<boost::multiprecision::gmp_int, boost::multiprecision::et_off>;
using Integers = std::vector<Integer>;

/// numerator * 2^exponent: what sums, differences and products of doubles are.
class Dyadic {
 public:
  Dyadic() = default;
  explicit Dyadic(double x);  ///< @pre finite
  Dyadic(Integer numerator, long exponent) : numerator_(std::move(numerator)), exponent_(exponent) {}

  int sign() const { return numerator_.sign(); }
  const Integer& numerator() const { return numerator_; }
  long exponent() const { return exponent_; }
  /// This number over 2^exponent. @pre an integer
  Integer over(long exponent) const;

  friend Dyadic operator+(const Dyadic& a, const Dyadic& b);
  friend Dyadic operator-(const Dyadic& a, const Dyadic& b);
  friend Dyadic operator*(const Dyadic& a, const Dyadic& b);
  friend Dyadic operator-(const Dyadic& a) { return {-a.numerator_, a.exponent_}; }
  friend bool operator<(const Dyadic& a, const Dyadic& b) { return (a - b).sign() < 0; }
  friend bool operator<=(const Dyadic& a, const Dyadic& b) { return (a - b).sign() <= 0; }

 private:
  Integer numerator_ = 0;
  long exponent_ = 0;
};

using DyadicVector = std::vector<Dyadic>;

Dyadic abs(const Dyadic& a);
const Dyadic& min(const Dyadic& a, const Dyadic& b);
const Dyadic& max(const Dyadic& a, const Dyadic& b);
/// a / b for a, b >= 0, to about 15 digits; 0/0 = 0, x/0 = infinity.
double quotient(const Dyadic& a, const Dyadic& b);

/// A dense matrix of exact numbers, zero at first.
template <class Number>
struct Table {
  Table() = default;
  Table(Index row_count, Index column_count)
      : rows(row_count), cols(column_count), entries(static_cast<std::size_t>(row_count * column_count)) {}
  Number& operator()(Index i, Index j) { return entries[static_cast<std::size_t>(i * cols + j)]; }
  const Number& operator()(Index i, Index j) const { return entries[static_cast<std::size_t>(i * cols + j)]; }

  Index rows = 0;
  Index cols = 0;
  std::vector<Number> entries;
};

using DyadicMatrix = Table<Dyadic>;
using IntegerMatrix = Table<Integer>;

DyadicMatrix exact(const Matrix& A);
DyadicVector exact(const Vector& x);
DyadicMatrix product(const DyadicMatrix& A, const DyadicMatrix& B);
DyadicMatrix transposed(const DyadicMatrix& A);
DyadicVector product(const DyadicMatrix& A, const DyadicVector& x);
Dyadic dot(const DyadicVector& a, const DyadicVector& b);

/// A^-1 = numerator / denominator, denominator > 0.
struct Inverse {
  DyadicMatrix numerator;
  Dyadic denominator{1.0};
};

/// No value where A is singular.
std::optional<Inverse> inverse(const DyadicMatrix& A);

/// All leading minors of a symmetric matrix are positive.
bool positive_definite(const DyadicMatrix& A);

/// x'A x >= 0 for all x, for a symmetric A.
bool positive_semidefinite(const DyadicMatrix& A);

/// The columns of A that do not depend on those before them.
std::vector<Index> independent_columns(const DyadicMatrix& A);

/// The system x = b + A y of linear inequalities x, y >= 0, some of them turned into equations x_i = 0 or y_j = 0, in
/// integers: every entry is a minor of the data, so that the divisions are exact. [Edmonds 1967]
/// Variables: x_i is i, y_j is rows + j.
class Inequalities {
 public:
  /// @param rows  of [b A]: each equation may be scaled by its own power of two, and so may each y_j
  explicit Inequalities(const DyadicMatrix& rows);

  Index rows() const { return row_count_; }
  Index columns() const { return column_count_; }

  /// From now on the variable is zero. False where that contradicts the equations alone.
  bool impose(Index variable);

  /// Whether some point satisfies all: the dual simplex method with cost zero and Bland's rule, which ends. Afterwards
  /// value() tells of a vertex.
  bool feasible();

  /// The sign of the variable at the vertex. @pre feasible() was true
  int sign(Index variable) const;

  /// The variable at that vertex, times denominator().
  Dyadic value(Index variable) const;
  const Integer& denominator() const { return denominator_; }

  /// After feasible() was false, and nothing imposed: u >= 0 of `rows` entries with A'u <= 0 and b'u < 0.
  DyadicVector contradiction() const;

 private:
  void pivot(std::size_t row, std::size_t column);
  Integer& entry(std::size_t row, std::size_t column) { return dictionary_[row][column + 1]; }

  Index row_count_ = 0;
  Index column_count_ = 0;
  std::vector<Integers> dictionary_;  // basic = (first entry + the others times nonbasic) / denominator_
  Integer denominator_ = 1;
  std::vector<Index> basic_;
  std::vector<Index> nonbasic_;
  std::vector<long> row_exponent_;
  std::vector<long> column_exponent_;  ///< of y_j at j + 1; that of b is zero
  std::size_t contradicting_row_ = 0;
};

}  // namespace lcpbench::attack
