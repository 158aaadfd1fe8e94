#include "native/velocity_ipm/coupled_compliance.h"

#include <cmath>
#include <type_traits>

namespace lcpbench {
namespace {

/// f(size), where 4, the edges of most friction pyramids, is a compile-time constant.
template <class F>
[[gnu::always_inline]] inline void with_size(Index size, const F& f) {
  if (size == 4) return f(std::integral_constant<Index, 4>());
  f(size);
}

/// K = L^-T, where L L' = diag(weights)^-1 + R. The row and column of a zero weight are zero. Where R is singular and
/// weights exceed 2^52 / R_ii, cancellation makes the last pivots meaningless. @returns a number, finite only if K is
template <class Size>
double factor_block(Size size, const double* R, const double* weights, double* K) {
  const auto at = [&](Index i, Index j) -> double& { return K[j * size + i]; };
  for (Index j = 0; j < size; ++j) {  // the lower triangle holds L
    for (Index i = j; i < size; ++i) {
      const bool counts = weights[i] > 0 && weights[j] > 0;
      double entry = counts ? R[j * size + i] : 0.0;
      if (i == j) entry += counts ? 1 / weights[i] : 1.0;
      for (Index k = 0; k < j; ++k) entry -= at(i, k) * at(j, k);
      at(i, j) = i == j ? std::sqrt(entry) : entry / at(j, j);
    }
  }
  double sum = 0;
  for (Index j = 0; j < size; ++j) {  // the upper triangle takes L^-T
    const double reciprocal = 1 / at(j, j);
    for (Index i = 0; i < j; ++i) {
      double entry = 0;
      for (Index k = i; k < j; ++k) entry += at(j, k) * at(i, k);
      at(i, j) = -entry * reciprocal;
    }
    at(j, j) = reciprocal;
    sum += reciprocal;
  }
  for (Index j = 0; j < size; ++j) {
    for (Index i = j + 1; i < size; ++i) at(i, j) = 0;
    for (Index k = j; k < size && !(weights[j] > 0); ++k) at(j, k) = 0;
  }
  return sum;
}

}  // namespace

void CoupledCompliance::add_block(const Matrix& R) {
  const Index first = blocks_.empty() ? 0 : blocks_.back().first + blocks_.back().size;
  blocks_.push_back({.first = first, .size = R.rows(), .value = R_.size()});
  R_.insert(R_.end(), R.data(), R.data() + R.size());
  roots_.resize(R_.size());
}

Vector CoupledCompliance::diagonal() const {
  Vector all(blocks_.empty() ? 0 : blocks_.back().first + blocks_.back().size);
  for (const Block& block : blocks_) {
    const Eigen::Map<const Matrix> R(R_.data() + block.value, block.size, block.size);
    all.segment(block.first, block.size) = R.diagonal();
  }
  return all;
}

void CoupledCompliance::add_product(const Vector& f, Vector& s) const {
  for (const Block& block : blocks_) {
    with_size(block.size, [&](auto size) {
      const double* R = R_.data() + block.value;
      double* const to = s.data() + block.first;
      for (Index j = 0; j < size; ++j, R += size) {
        for (Index i = 0; i < size; ++i) to[i] += f(block.first + j) * R[i];
      }
    });
  }
}

bool CoupledCompliance::factor(const Vector& weights) {
  double sum = 0;
  for (const Block& block : blocks_) {
    with_size(block.size, [&](auto size) {
      sum += factor_block(size, R_.data() + block.value, weights.data() + block.first, roots_.data() + block.value);
    });
  }
  return std::isfinite(sum);
}

void CoupledCompliance::apply_weights(Vector& x) const {
  for (const Block& block : blocks_) {
    with_size(block.size, [&](auto size) {
      const double* const K = root(block);
      double* const part = x.data() + block.first;
      for (Index j = size; j-- > 0;) {
        double sum = 0;
        for (Index i = 0; i <= j; ++i) sum += K[j * size + i] * part[i];
        part[j] = sum;
      }
      for (Index i = 0; i < size; ++i) {
        double sum = 0;
        for (Index j = i; j < size; ++j) sum += K[j * size + i] * part[j];
        part[i] = sum;
      }
    });
  }
}

}  // namespace lcpbench
