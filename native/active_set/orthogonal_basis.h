#pragma once

#include "native/active_set/arithmetic.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// Vectors a_0, a_1, ... of fixed length as A = Q R: Q orthonormal, R upper triangular with positive diagonal.
///
/// Vectors are appended by Gram-Schmidt with a second pass where the first cancels, which keeps Q orthogonal to
/// rounding [Daniel, Gragg, Kaufman, Stewart 1976], and removed by Givens rotations. O(length * size) for either.
class OrthogonalBasis {
  using L = Lanes<double>;

 public:
  /// Room for `capacity` vectors of `length` entries (padded), or for fewer and shorter ones.
  void reserve(Count length, Count capacity) {
    q_.resize(length * (capacity + 1) + 1);
    r_.resize(capacity * capacity + 1);
    inverse_diagonal_.resize(capacity + 1);
    minus_along_.resize(capacity + 1);
  }
  /// Empty. @pre reserve()
  void clear(Count length, Count capacity) {
    length_ = length;
    capacity_ = capacity;
    size_ = 0;
  }

  Count size() const { return size_; }
  const double* q(Count i) const { return q_.data() + i * length_; }
  /// R(i, j), i <= j.
  double r(Count i, Count j) const { return r_[j * capacity_ + i]; }

  /// coefficients (size) = Q'x, rest = x - Q Q'x. @returns |rest|^2
  double split(const double* x, double squared_norm, double* coefficients, double* rest) {
    double left = squared_norm;
    for (Count k = 0; k < size_; ++k) {
      const double along = dot(q(k), x, length_);
      coefficients[k] = along;
      minus_along_[k] = -along;
      left -= along * along;
    }
    combine_rows(rest, x, q_.data(), length_, minus_along_.data(), size_, length_);
    if (size_ == 0 || left > kEnoughLeft * squared_norm) return left;
    for (Count k = 0; k < size_; ++k) minus_along_[k] = -dot(q(k), rest, length_);
    combine_rows(rest, rest, q_.data(), length_, minus_along_.data(), size_, length_);
    for (Count k = 0; k < size_; ++k) coefficients[k] -= minus_along_[k];
    return dot(rest, rest, length_);
  }

  /// Appends the vector that split() took apart. @pre size() < capacity, squared_rest > 0
  void append(const double* coefficients, const double* rest, double squared_rest) {
    const double norm = square_root(squared_rest);
    double* column = r_.data() + size_ * capacity_;
    for (Count k = 0; k < size_; ++k) column[k] = coefficients[k];
    column[size_] = norm;
    inverse_diagonal_[size_] = 1 / norm;
    double* direction = q_.data() + size_ * length_;
    copy(direction, rest, length_);
    scale(direction, inverse_diagonal_[size_], length_);
    ++size_;
  }

  /// Removes vector `k`; those after it move up by one.
  void remove(Count k) {
    for (Count j = k + 1; j < size_; ++j) {
      const double* from = r_.data() + j * capacity_;
      double* to = r_.data() + (j - 1) * capacity_;
      for (Count i = 0; i <= j; ++i) to[i] = from[i];
    }
    --size_;
    for (Count i = k; i < size_; ++i) rotate(i);
  }

  /// x := R^-1 x.
  void solve(double* x) const {
    for (Count j = size_ - 1; j >= 0; --j) {
      const double* column = r_.data() + j * capacity_;
      const double value = x[j] * inverse_diagonal_[j];
      x[j] = value;
      for (Count i = 0; i < j; ++i) x[i] -= value * column[i];
    }
  }

  /// x := R^-T x.
  void solve_transposed(double* x) const {
    for (Count j = 0; j < size_; ++j) {
      const double* column = r_.data() + j * capacity_;
      for (Count i = 0; i < j; ++i) x[j] -= column[i] * x[i];
      x[j] *= inverse_diagonal_[j];
    }
  }

 private:
  /// Of the squared length. Much less would do for one vector, but what each loses is lost again by those after it.
  static constexpr double kEnoughLeft = 0.5;

  /// Makes R(i + 1, i) zero by turning directions i and i + 1.
  void rotate(Count i) {
    double* pivot = r_.data() + i * capacity_ + i;
    const double norm = square_root(pivot[0] * pivot[0] + pivot[1] * pivot[1]);
    const double inverse = 1 / norm;
    const double c = pivot[0] * inverse;
    const double s = pivot[1] * inverse;
    pivot[0] = norm;
    inverse_diagonal_[i] = inverse;
    for (Count j = i + 1; j < size_; ++j) {
      double* entry = r_.data() + j * capacity_ + i;
      const double above = c * entry[0] + s * entry[1];
      entry[1] = c * entry[1] - s * entry[0];
      entry[0] = above;
    }
    double* q0 = q_.data() + i * length_;
    double* q1 = q0 + length_;
    for (Count l = 0; l < length_; l += L::kWidth) {
      const auto first = L::load(q0 + l);
      const auto second = L::load(q1 + l);
      L::store(q0 + l, c * first + s * second);
      L::store(q1 + l, c * second - s * first);
    }
  }

  Count length_ = 0;
  Count capacity_ = 0;
  Count size_ = 0;
  Buffer<double> q_;  // one direction after the other
  Buffer<double> r_;  // capacity x capacity by columns
  Buffer<double> inverse_diagonal_;
  Buffer<double> minus_along_;
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
