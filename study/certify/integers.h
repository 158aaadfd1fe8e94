#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <flint/fmpz.h>
#include <flint/fmpz_mat.h>
#include <flint/nmod_mat.h>

#include "core/types.h"
#include "study/certify/deadline.h"

namespace lcpbench::exact {

/// An Index as a subscript of a std::vector.
constexpr std::size_t index(Index i) { return static_cast<std::size_t>(i); }

/// An integer of any size: FLINT's fmpz with an owner.
class Integer {
 public:
  Integer() { fmpz_init(value_); }
  explicit Integer(slong value) {
    fmpz_init(value_);
    fmpz_set_si(value_, value);
  }
  Integer(const Integer& other) { fmpz_init_set(value_, other.value_); }
  Integer(Integer&& other) noexcept {
    fmpz_init(value_);
    fmpz_swap(value_, other.value_);
  }
  Integer& operator=(Integer other) noexcept {
    fmpz_swap(value_, other.value_);
    return *this;
  }
  ~Integer() { fmpz_clear(value_); }

  fmpz* get() { return value_; }
  const fmpz* get() const { return value_; }
  int sign() const { return fmpz_sgn(value_); }

 private:
  fmpz_t value_;
};

using IntegerVector = std::vector<Integer>;

/// Multiplies by 2^by, for by >= 0; otherwise leaves the value.
inline void shift_left(Integer& value, slong by) {
  if (by > 0) fmpz_mul_2exp(value.get(), value.get(), static_cast<ulong>(by));
}

/// A dense matrix of integers, zero at first: FLINT's fmpz_mat with an owner.
class IntegerMatrix {
 public:
  IntegerMatrix() : IntegerMatrix(0, 0) {}
  IntegerMatrix(Index rows, Index cols) { fmpz_mat_init(matrix_, rows, cols); }
  IntegerMatrix(const IntegerMatrix& other) { fmpz_mat_init_set(matrix_, other.matrix_); }
  IntegerMatrix(IntegerMatrix&& other) noexcept : IntegerMatrix() { fmpz_mat_swap(matrix_, other.matrix_); }
  IntegerMatrix& operator=(IntegerMatrix other) noexcept {
    fmpz_mat_swap(matrix_, other.matrix_);
    return *this;
  }
  ~IntegerMatrix() { fmpz_mat_clear(matrix_); }

  Index rows() const { return fmpz_mat_nrows(matrix_); }
  Index cols() const { return fmpz_mat_ncols(matrix_); }
  fmpz* operator()(Index i, Index j) { return fmpz_mat_entry(matrix_, i, j); }
  const fmpz* operator()(Index i, Index j) const { return fmpz_mat_entry(matrix_, i, j); }
  fmpz_mat_struct* get() { return matrix_; }
  const fmpz_mat_struct* get() const { return matrix_; }

 private:
  fmpz_mat_t matrix_;
};

/// A matrix modulo a prime: FLINT's nmod_mat with an owner.
class Residues {
 public:
  Residues() { nmod_mat_init(matrix_, 0, 0, 1); }
  Residues(const IntegerMatrix& a, mp_limb_t prime) {
    nmod_mat_init(matrix_, a.rows(), a.cols(), prime);
    fmpz_mat_get_nmod_mat(matrix_, a.get());
  }
  Residues(const Residues&) = delete;
  Residues& operator=(Residues&& other) noexcept {
    nmod_mat_swap(matrix_, other.matrix_);
    return *this;
  }
  ~Residues() { nmod_mat_clear(matrix_); }

  nmod_mat_struct* get() { return matrix_; }
  const nmod_mat_struct* get() const { return matrix_; }

 private:
  nmod_mat_t matrix_;
};

/// @throws TimePassed
IntegerMatrix product(const IntegerMatrix& a, const IntegerMatrix& b, const Deadline& deadline);
IntegerMatrix transposed(const IntegerMatrix& a);
IntegerMatrix columns(const IntegerMatrix& a, const std::vector<Index>& which);

/// A double: odd * 2^exponent.
struct Parts {
  std::int64_t odd = 0;  ///< 0 for the double 0
  slong exponent = 0;
};

/// @pre finite
Parts dyadic(double value);

/// m * 2^exponent.
struct Dyadic {
  IntegerMatrix m;
  slong exponent = 0;
};

/// The doubles of `a` exactly, over the largest power of two that divides them all. @pre finite.
Dyadic to_dyadic(const Matrix& a);

/// Each entry correctly rounded.
Matrix to_doubles(const Dyadic& a);

/// The same numbers, written with a smaller power of two and larger m. @pre exponent <= a.exponent
Dyadic refined(Dyadic a, slong exponent);

/// @throws TimePassed
Dyadic product(const Dyadic& a, const Dyadic& b, const Deadline& deadline);
Dyadic transposed(const Dyadic& a);

/// numerator * 2^shift / denominator, rounded to the nearest double, ties to even; infinity beyond the largest double.
/// @pre denominator > 0
double rounded(const Integer& numerator, slong shift, const Integer& denominator);

/// In decimal.
std::string text(const Integer& value);

}  // namespace lcpbench::exact
