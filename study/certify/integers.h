#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <vector>

#include <flint/fmpz.h>
#include <flint/fmpz_mat.h>

#include "core/types.h"
#include "study/certify/deadline.h"

namespace lcpbench::exact {

/// An Index as a subscript of a std::vector.
constexpr std::size_t index(Index i) { return static_cast<std::size_t>(i); }

/// FLINT's fmpz with an owner.
class Integer {
 public:
  Integer() { fmpz_init(value_); }
  explicit Integer(slong value) { fmpz_init_set_si(value_, value); }
  explicit Integer(const fmpz* value) { fmpz_init_set(value_, value); }
  Integer(const Integer& other) : Integer(other.value_) {}
  Integer& operator=(Integer other) noexcept {
    fmpz_swap(value_, other.value_);
    return *this;
  }
  ~Integer() { fmpz_clear(value_); }

  fmpz* get() { return value_; }
  const fmpz* get() const { return value_; }

 private:
  fmpz_t value_;
};

/// FLINT's fmpz_mat with an owner; zero at first.
class IntegerMatrix {
 public:
  explicit IntegerMatrix(Index rows = 0, Index cols = 1) { fmpz_mat_init(matrix_, rows, cols); }
  IntegerMatrix(const IntegerMatrix& other) { fmpz_mat_init_set(matrix_, other.matrix_); }
  IntegerMatrix(IntegerMatrix&& other) noexcept : IntegerMatrix() { fmpz_mat_swap(matrix_, other.matrix_); }
  IntegerMatrix& operator=(IntegerMatrix other) noexcept {
    fmpz_mat_swap(matrix_, other.matrix_);
    return *this;
  }
  ~IntegerMatrix() { fmpz_mat_clear(matrix_); }

  Index rows() const { return fmpz_mat_nrows(matrix_); }
  Index cols() const { return fmpz_mat_ncols(matrix_); }
  fmpz* operator()(Index i, Index j = 0) { return fmpz_mat_entry(matrix_, i, j); }
  const fmpz* operator()(Index i, Index j = 0) const { return fmpz_mat_entry(matrix_, i, j); }
  bool is_zero(Index i, Index j = 0) const { return fmpz_is_zero((*this)(i, j)) != 0; }
  int sign(Index i, Index j = 0) const { return fmpz_sgn((*this)(i, j)); }
  fmpz_mat_struct* get() { return matrix_; }
  const fmpz_mat_struct* get() const { return matrix_; }

 private:
  fmpz_mat_t matrix_;
};

IntegerMatrix operator*(const IntegerMatrix& a, const IntegerMatrix& b);
IntegerMatrix transposed(const IntegerMatrix& a);
IntegerMatrix part(const IntegerMatrix& a, const std::vector<Index>& rows, const std::vector<Index>& cols);

/// begin, begin + 1, ..., end - 1.
std::vector<Index> range(Index begin, Index end);

/// The columns of A that do not depend on those before, modulo a prime of 63 bits: independent over the integers. With
/// a probability near 2^-63 one is left out that is independent.
std::vector<Index> independent_columns(const IntegerMatrix& A, const Deadline& deadline);

/// A X = denominator B, exactly, for any number of right-hand sides. @param A  nonsingular, square
/// @throws TimePassed where the time left will not do: FLINT cannot be interrupted
void solve(IntegerMatrix A, const IntegerMatrix& B, IntegerMatrix& X, Integer& denominator, const Deadline& deadline);

/// A x = denominator b on a largest independent part of these equations: the first rows, and the first columns of A,
/// that do not depend on those before; the other x are 0. @throws TimePassed
IntegerMatrix determined(const IntegerMatrix& A, const IntegerMatrix& b, Integer& denominator,
                         const Deadline& deadline);

/// m * 2^exponent.
struct Dyadic {
  IntegerMatrix m{};
  slong exponent = 0;
};

/// The doubles of `a` exactly. @pre finite
Dyadic to_dyadic(const Matrix& a);
Dyadic operator*(const Dyadic& a, const Dyadic& b);
Dyadic operator+(const Dyadic& a, const Dyadic& b);
Dyadic operator-(Dyadic a);
Dyadic transposed(const Dyadic& a);
/// The matrices side by side. @pre as many rows in each
Dyadic beside(std::initializer_list<const Dyadic*> matrices);
template <class... Matrices>
Dyadic beside(const Matrices&... matrices) {
  return beside({&matrices...});
}

/// numerator / denominator, rounded to the nearest double, ties to even; infinity beyond the largest double.
/// @pre denominator > 0
double rounded(const fmpz* numerator, const Integer& denominator);

/// In decimal.
std::string text(const fmpz* value);

}  // namespace lcpbench::exact
