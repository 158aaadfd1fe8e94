#include <numeric>

#include "generators/hard/build.h"

namespace lcpbench::hard {
namespace {

// ---- ill-conditioned ----

/// The least common multiple of 1..last; below 2^53 for last <= 40.
double common_multiple(std::size_t last) {
  std::size_t multiple = 1;
  for (std::size_t i = 2; i <= last; ++i) multiple = std::lcm(multiple, i);
  return static_cast<double>(multiple);
}

/// l / (i + j + 1), where l is the smallest number that makes every entry an integer.
Table integer_hilbert(std::size_t n) {
  const double multiple = common_multiple(2 * n - 1);
  Table M(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) M(i, j) = multiple / static_cast<double>(i + j + 1);
  }
  return M;
}

constexpr const char* kDefinite = "M is positive definite, z = e";
/// Up to n = 18 the row sums are below 2^53, so that q = -M e is exact.
using HilbertDial = OrderDial<10, 1, 18>;

HardCase make_hilbert(HilbertDial n) { return planted_ones(integer_hilbert(n), HardUnique::kYes, kDefinite); }

HardCase make_hilbert_mixed(HilbertDial n) {
  return planted(integer_hilbert(n), alternating(n), alternating(n, 1), HardUnique::kYes,
                 "M is positive definite, z = (1, 0, 1, ...)");
}

/// Row sums are below 2^53 up to n = 28.
HardCase make_pascal(OrderDial<18, 1, 28> n) {
  Table M(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) M(i, j) = i == 0 || j == 0 ? 1 : M(i - 1, j) + M(i, j - 1);
  }
  return planted_ones(M, HardUnique::kYes, kDefinite);
}

HardCase make_lotkin(OrderDial<8, 1, 18> n) {
  Table M = integer_hilbert(n);
  for (std::size_t j = 0; j < M.cols; ++j) M(0, j) = M(0, 0);
  return planted_ones(M, HardUnique::kUnknown, "z = e");
}

HardCase make_moler(OrderDial<20, 1, 200> n) {
  const Table L = triangular(n, -1, 1, 0);
  return planted_ones(product(L, transposed(L)), HardUnique::kYes, kDefinite);
}

// A principal submatrix of order k with the last row is this matrix of order k, with the determinant 2^(k - 1); without
// the last row it is unit lower triangular. So every principal minor is positive.
HardCase make_growth(OrderDial<40, 1, 200> n) {
  Table M = triangular(n, -1, 1, 0);
  for (std::size_t i = 0; i < M.rows; ++i) M(i, M.cols - 1) = 1;
  return planted_ones(M, HardUnique::kYes, "M is a P-matrix, z = e");
}

// ---- scaling ----

struct ScalingDials {
  std::int64_t range = 40;
  std::int64_t n = 12;
  void visit(auto&& field) {
    field("range", range, IntegerRange{0, 200}, "the factors are powers of two from 2^-range to 2^range");
    field("n", n, IntegerRange{1, 200}, "order of M");
  }
};

/// n factors 2^(range k / 5), exponents rounded towards 0: k takes the values from -5 to 5 in an order in which
/// neighbours differ much, over and over.
Numbers scattered_powers(const ScalingDials& dials) {
  constexpr std::int64_t kSteps = 5;  // on either side of 1
  Numbers factors;
  for (std::int64_t i = 0; i < dials.n; ++i) {
    const std::int64_t step = 5 * i % (2 * kSteps + 1) - kSteps;
    factors.push_back(power_of_two(dials.range * step / kSteps));
  }
  return factors;
}

/// The matrix diag(rows) M diag(columns) with q = -diag(rows) M e, which z = diag(columns)^-1 e solves.
/// @param reason  why the solution is unique
HardCase scaled_problem(Table M, const Numbers& row_factors, const Numbers& column_factors, const char* reason) {
  Numbers z(M.rows);
  for (std::size_t j = 0; j < M.cols; ++j) {
    z[j] = 1 / column_factors[j];
    for (std::size_t i = 0; i < M.rows; ++i) M(i, j) *= row_factors[i] * column_factors[j];
  }
  return planted(std::move(M), z, constant(z.size(), 0), HardUnique::kYes, reason);
}

Table well_scaled(const ScalingDials& dials) { return tridiagonal(static_cast<std::size_t>(dials.n), -1, 4, -1); }
Numbers ones(const ScalingDials& dials) { return constant(static_cast<std::size_t>(dials.n), 1); }

HardCase make_symmetric(const ScalingDials& dials) {
  const Numbers factors = scattered_powers(dials);
  return scaled_problem(well_scaled(dials), factors, factors, "M is positive definite");
}

HardCase make_rows(const ScalingDials& dials) {
  return scaled_problem(well_scaled(dials), scattered_powers(dials), ones(dials), "M is a P-matrix, z = e");
}

HardCase make_columns(const ScalingDials& dials) {
  return scaled_problem(well_scaled(dials), ones(dials), scattered_powers(dials), "M is a P-matrix");
}

struct SmallBlockDials {
  std::int64_t bits = 40;
  std::int64_t n = 4;
  void visit(auto&& field) {
    field("bits", bits, IntegerRange{0, 500}, "the second block and its q are those of the first times 2^-bits");
    field("n", n, IntegerRange{1, 100}, "rows of each block");
  }
};

HardCase make_small_block(const SmallBlockDials& dials) {
  const auto n = static_cast<std::size_t>(dials.n);
  const Table block = tridiagonal(n, -1, 4, -1);
  const double factor = power_of_two(-dials.bits);
  Table M(2 * n, 2 * n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      M(i, j) = block(i, j);
      M(n + i, n + j) = factor * block(i, j);
    }
  }
  return planted_ones(M, HardUnique::kYes, kDefinite);
}

}  // namespace

std::vector<HardSet> conditioning_sets() {
  return {
#include "generators/hard/conditioning.inc"
  };
}

}  // namespace lcpbench::hard
