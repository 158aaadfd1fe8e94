#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/quad.h"
#include "core/types.h"

// Cholesky factors of small positive definite blocks, in double or Quad. L is stored by columns of n entries, with its
// diagonal (not the inverses, as the kernels of cholesky_engine.h store it). What stands above the diagonal is neither
// written nor read. kSize is the order n where the compiler knows it, else 0: then n is block.rows() or `order`.

namespace lcpbench {

inline double root_of(double x) { return std::sqrt(x); }
inline Quad root_of(Quad x) { return sqrt(x); }

/// L of block = L L'. @returns whether the block is positive definite; if not, L means nothing
template <int kSize, class Scalar>
bool factor_block(const Matrix& block, Scalar* L) {
  const std::size_t n = kSize > 0 ? kSize : static_cast<std::size_t>(block.rows());
  bool is_definite = true;
  for (std::size_t j = 0; j < n; ++j) {
    Scalar* const column = L + j * n;
    const double* const given = block.data() + j * n;
    for (std::size_t i = j; i < n; ++i) column[i] = static_cast<Scalar>(given[i]);
    std::size_t k = 0;
    for (; k + 4 <= j; k += 4) {
      const Scalar* const b = L + k * n;
      for (std::size_t i = j; i < n; ++i) {
        column[i] =
            column[i] - b[i] * b[j] - b[n + i] * b[n + j] - b[2 * n + i] * b[2 * n + j] - b[3 * n + i] * b[3 * n + j];
      }
    }
    for (; k < j; ++k) {
      const Scalar* const before = L + k * n;
      for (std::size_t i = j; i < n; ++i) column[i] -= before[i] * before[j];
    }
    is_definite = is_definite && column[j] > 0;
    const Scalar diagonal = root_of(column[j] > 0 ? column[j] : Scalar(1));
    for (std::size_t i = j + 1; i < n; ++i) column[i] /= diagonal;
    column[j] = diagonal;
  }
  return is_definite;
}

/// lengths_j := |column j of L^-1|, which is sqrt(((L L')^-1)_jj); four columns together. @param scratch  4 n entries
template <int kSize, class Scalar>
void measure_inverse(const Scalar* L, std::size_t order, Scalar* scratch, Scalar* lengths) {
  using Four = Eigen::Array<Scalar, 4, 1>;
  const std::size_t n = kSize > 0 ? kSize : order;
  for (std::size_t first = 0; first < n; first += 4) {
    std::fill(scratch + 4 * first, scratch + 4 * n, Scalar(0));
    const std::size_t together = std::min<std::size_t>(4, n - first);
    for (std::size_t k = 0; k < together; ++k) scratch[4 * (first + k) + k] = 1;
    Four squares = Four::Zero();
    for (std::size_t i = first; i < n; ++i) {
      Eigen::Map<Four> now(scratch + 4 * i);
      const Four x = now / L[i * n + i];
      squares += x * x;
      for (std::size_t l = i + 1; l < n; ++l) Eigen::Map<Four>(scratch + 4 * l) -= L[i * n + l] * x;
    }
    for (std::size_t k = 0; k < together; ++k) lengths[first + k] = root_of(squares(static_cast<Index>(k)));
  }
}

/// x := L^-1 x
template <int kSize, class Scalar>
void solve_lower(const Scalar* L, std::size_t order, Scalar* x) {
  const std::size_t n = kSize > 0 ? kSize : order;
  for (std::size_t i = 0; i < n; ++i) {
    x[i] /= L[i * n + i];
    for (std::size_t k = i + 1; k < n; ++k) x[k] -= L[i * n + k] * x[i];
  }
}

/// x := (L L')^-1 x
template <int kSize, class Scalar>
void solve_block(const Scalar* L, std::size_t order, Scalar* x) {
  const std::size_t n = kSize > 0 ? kSize : order;
  solve_lower<kSize>(L, n, x);
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) x[i] -= L[i * n + k] * x[k];
    x[i] /= L[i * n + i];
  }
}

/// L of block = L L', reach_j := sqrt((block^-1)_jj), x := block^-1 x. @param scratch  4 n entries
/// @returns whether the block is positive definite; if not, L, reach and x mean nothing
template <int kSize, class Scalar>
bool respond_block(const Matrix& block, Scalar* L, Scalar* scratch, Scalar* reach, Scalar* x) {
  const bool is_definite = factor_block<kSize>(block, L);
  const auto n = static_cast<std::size_t>(block.rows());
  measure_inverse<kSize>(L, n, scratch, reach);
  solve_block<kSize>(L, n, x);
  return is_definite;
}

}  // namespace lcpbench
