#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/dyadic.h"
#include "core/types.h"

namespace lcpbench {

/// A matrix without any rounding, stored by rows.
struct ExactMatrix {
  Index rows = 0;
  Index cols = 0;
  std::vector<Dyadic> entries;

  ExactMatrix(Index row_count, Index column_count)
      : rows(row_count), cols(column_count), entries(static_cast<std::size_t>(row_count * column_count)) {}
  explicit ExactMatrix(const Matrix& doubles);

  Dyadic& operator()(Index i, Index j) { return entries[static_cast<std::size_t>(i * cols + j)]; }
  const Dyadic& operator()(Index i, Index j) const { return entries[static_cast<std::size_t>(i * cols + j)]; }
};

/// The functions below return nullopt where they would need a longer determinant than that [bits]: this bounds their
/// time, and depends on the data alone.
inline constexpr std::int64_t kMostExactBits = std::int64_t{1} << 15;

ExactMatrix transposed(const ExactMatrix& A);
ExactMatrix product(const ExactMatrix& A, const ExactMatrix& B);
/// These columns of A, in this order.
ExactMatrix columns_of(const ExactMatrix& A, const std::vector<Index>& columns);

/// Columns of A that are independent and span its range. Their number is the rank of A.
///
/// By elimination modulo primes: what is independent modulo one of them is independent, and what depends modulo primes
/// whose product exceeds every minor depends. nullopt beyond kMostExactBits.
std::optional<std::vector<Index>> independent_columns(const ExactMatrix& A);

/// Whether the symmetric A is positive definite: all its leading minors are positive. nullopt beyond kMostExactBits.
std::optional<bool> is_positive_definite(const ExactMatrix& A);

/// x = numerators / denominator.
struct ExactSolution {
  std::vector<Dyadic> numerators;
  Dyadic denominator;  ///< positive; zero where A is singular
};

/// The solution of A x = b for a square A, by elimination modulo primes whose product exceeds every minor. nullopt
/// beyond kMostExactBits. @pre b has A.rows entries
std::optional<ExactSolution> solve_exactly(const ExactMatrix& A, const std::vector<Dyadic>& b);

/// The inverse of a positive definite A is numerator / denominator, denominator > 0. nullopt beyond kMostExactBits.
struct ExactInverse {
  ExactMatrix numerator;
  Dyadic denominator;
};
std::optional<ExactInverse> inverse_of_definite(ExactMatrix A);

}  // namespace lcpbench
