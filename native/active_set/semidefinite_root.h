#pragma once

#include "native/active_set/active_set_engine.h"
#include "native/active_set/arithmetic.h"
#include "native/active_set/orthogonal_basis.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// S (ngc x rank) with G* = S S', for an inertia of any rank.
///
/// From factors, G = Y Y': Y = Q R, then R' = P T, both by Gram-Schmidt, so that G = Q T'T Q' and S = Q T^-1; the
/// condition number is never squared: O(factors ngc^3). From G* by Cholesky with diagonal pivoting: O(ngc^3).
///
/// The columns of S are written to the first `rank` rows that the caller provides: `ngc` rows, `stride` from one to the
/// next, of which the first padded(ngc) entries are used, as memory too.
class SemidefiniteRoot {
  using L = Lanes<double>;

 public:
  /// @param factors  columns of Y
  void reserve(Count ngc, Count factors) {
    const Count most = factors > ngc ? factors : ngc;
    const Count lanes = L::padded(ngc);
    factors_.resize(factors * lanes + 1);
    coefficients_.resize(L::padded(most) * (ngc + 1) + 1);
    rest_.resize(L::padded(most) + 1);
    order_.resize(most + 1);
    diagonal_.resize(ngc + 1);
    range_.reserve(lanes, ngc);
    rank_basis_.reserve(L::padded(most), ngc);
  }

  void set_rows(double* rows, Count stride, Count ngc) {
    rows_ = rows;
    stride_ = stride;
    ngc_ = ngc;
    lanes_ = L::padded(ngc);
  }

  // Each of these is false where the inertia is indefinite or not a number. Apart from the code of positive definite
  // inertia, whose microseconds must not depend on what is inlined here.

  /// Of G = X diag(alpha) X'.
  [[gnu::noinline]] bool find_of_factors(const Input& input) {
    factor_count_ = input.factors;
    for (Count k = 0; k < factor_count_; ++k) {
      const double weight = square_root(input.alpha[k]);
      double* column = factors_.data() + k * lanes_;
      for (Count i = 0; i < ngc_; ++i) column[i] = weight * input.matrix[k * ngc_ + i];
      for (Count i = ngc_; i < lanes_; ++i) column[i] = 0;
    }
    return find_of_range();
  }

  /// Of G*, singular to within `cut`, each coordinate by its own diagonal entry: a heavy body beside a light one must
  /// not count as a body that nothing moves.
  [[gnu::noinline]] bool find_of_inverse(const double* inverse, double cut) {
    if (!read_diagonal(inverse)) return false;
    if (!factor_semidefinite(inverse, cut)) return false;
    rank_ = factor_count_;
    for (Count k = 0; k < rank_; ++k) copy(row(k), factors_.data() + k * lanes_, lanes_);
    return true;
  }

  Count rank() const { return rank_; }
  /// How much rounding errors grow in S, about.
  double growth() const { return growth_; }

 private:
  double* row(Count i) { return rows_ + i * stride_; }

  /// False where an entry is not a number or below zero.
  bool read_diagonal(const double* A) {
    for (Count i = 0; i < ngc_; ++i) {
      diagonal_[i] = A[i * ngc_ + i];
      if (!(diagonal_[i] >= 0) || !finite(diagonal_[i])) return false;
    }
    return true;
  }

  /// A = Y Y' to within `cut` times ngc times the entries of diagonal_, by Cholesky with diagonal pivoting.
  /// False when A is indefinite. Uses the rows as memory.
  bool factor_semidefinite(const double* A, double cut) {
    for (Count i = 0; i < ngc_; ++i) {
      double* to = row(i);
      for (Count j = 0; j < ngc_; ++j) to[j] = A[i * ngc_ + j];
    }
    const double share = static_cast<double>(ngc_) * cut;
    double growth = 1;
    for (factor_count_ = 0; factor_count_ < ngc_; ++factor_count_) {
      Count pivot = -1;
      for (Count i = 0; i < ngc_; ++i) {
        if (row(i)[i] > share * diagonal_[i] && (pivot < 0 || row(i)[i] > row(pivot)[pivot])) pivot = i;
      }
      if (pivot < 0) break;
      const double cancelled = diagonal_[pivot] / row(pivot)[pivot];
      growth = cancelled > growth ? cancelled : growth;
      take_factor(pivot);
    }
    for (Count i = 0; i < ngc_; ++i) {
      if (!(row(i)[i] >= -share * diagonal_[i])) return false;
    }
    growth_ = square_root(growth);
    return true;
  }

  /// The next column of Y, and A less its part.
  void take_factor(Count pivot) {
    double* column = factors_.data() + factor_count_ * lanes_;
    const double inverse = 1 / square_root(row(pivot)[pivot]);
    for (Count i = 0; i < ngc_; ++i) column[i] = inverse * row(pivot)[i];
    for (Count i = ngc_; i < lanes_; ++i) column[i] = 0;
    for (Count i = 0; i < ngc_; ++i) {
      for (Count j = 0; j < ngc_; ++j) row(i)[j] -= column[i] * column[j];
    }
    for (Count i = 0; i < ngc_; ++i) row(i)[pivot] = row(pivot)[i] = 0;
  }

  /// Of G = Y Y', the factors found.
  bool find_of_range() {
    if (!factor_range()) return false;
    // R' = P T: the rows of R, which are independent.
    const Count length = coefficient_lanes();
    rank_basis_.clear(length, ngc_);
    double least = kInfinity<double>;
    double largest = 0;
    for (Count i = 0; i < rank_; ++i) {
      const double* of_range = coefficients_.data() + i * length;
      double* t = coefficients_.data() + ngc_ * length;
      const double left = rank_basis_.split(of_range, dot(of_range, of_range, length), t, rest_.data());
      if (!(left > 0)) return false;
      rank_basis_.append(t, rest_.data(), left);
      least = left < least ? left : least;
      largest = left > largest ? left : largest;
    }
    for (Count i = 0; i < rank_; ++i) {
      copy(row(i), range_.q(i), lanes_);
      for (Count j = 0; j < i; ++j) add_multiple(row(i), -rank_basis_.r(j, i), row(j), lanes_);
      scale(row(i), 1 / rank_basis_.r(i, i), lanes_);
    }
    growth_ = rank_ > 0 ? square_root(largest / least) : 1.0;
    return true;
  }

  /// Of a row of R.
  Count coefficient_lanes() const { return L::padded(factor_count_ > ngc_ ? factor_count_ : ngc_); }

  /// Q of Y = Q R, always the column that stands out most next; rows of R in coefficients_. A factor belongs to the
  /// range of the others when less than 2^-46 of its length stands out of it.
  bool factor_range() {
    const Count count = factor_count_;
    const Count length = coefficient_lanes();
    const double cut = 0x1p-46;
    set_zero(coefficients_.data(), length * (ngc_ + 1));
    range_.clear(lanes_, ngc_);
    for (Count k = 0; k < count; ++k) order_[k] = k;
    double* c = coefficients_.data() + ngc_ * length;
    for (rank_ = 0; rank_ < ngc_ && rank_ < count; ++rank_) {
      Count best = -1;
      double most = 0;
      for (Count k = rank_; k < count; ++k) {
        const double* factor = factors_.data() + order_[k] * lanes_;
        const double squared = dot(factor, factor, lanes_);
        if (!finite(squared)) return false;
        const double left = range_.split(factor, squared, c, rest_.data());
        if (left > cut * cut * squared && left > most) {
          most = left;
          best = k;
        }
      }
      if (best < 0) break;
      swap(order_[rank_], order_[best]);
      const double* factor = factors_.data() + order_[rank_] * lanes_;
      const double left = range_.split(factor, dot(factor, factor, lanes_), c, rest_.data());
      range_.append(c, rest_.data(), left);
    }
    for (Count i = 0; i < rank_; ++i) {
      for (Count k = 0; k < count; ++k) {
        coefficients_[i * length + k] = dot(range_.q(i), factors_.data() + k * lanes_, lanes_);
      }
    }
    set_zero(c, length);
    return true;
  }

  double* rows_ = nullptr;
  Count stride_ = 0;
  Count ngc_ = 0;
  Count lanes_ = 0;
  Count rank_ = 0;
  double growth_ = 1;
  Count factor_count_ = 0;
  Buffer<double> factors_;  // Y by columns
  Buffer<double> coefficients_;
  Buffer<double> rest_;
  Buffer<Count> order_;
  Buffer<double> diagonal_;  // what a pivot of each coordinate is compared with
  OrthogonalBasis range_;
  OrthogonalBasis rank_basis_;
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
