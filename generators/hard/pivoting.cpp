#include "generators/hard/build.h"

namespace lcpbench::hard {
namespace {

// ---- cycling ----

/// Row i has `diagonal` in column i, `first` in i + step and `second` in i + 2 step, cyclically.
Table circulant(std::size_t n, double diagonal, double first, double second, std::size_t step) {
  Table M(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    M(i, i) += diagonal;
    M(i, (i + step) % n) += first;
    M(i, (i + 2 * step) % n) += second;
  }
  return M;
}

HardCase make_kostreva(ScaleDial scale) {
  return with_scale(planted_ones(circulant(3, 1, 2, 0, 1), HardUnique::kYes, "M is a P-matrix, z = e"), scale);
}

HardCase make_morris(OddOrderDial<2, 100> n) {
  return planted_ones(circulant(n, 1, 2, 0, 1), HardUnique::kYes, "M is a P-matrix, z = e");
}

HardCase make_newton_odd(OddOrderDial<3, 100> n) {
  return lcp(circulant(n, 1, 2, 0, n - 1), constant(n, 1),
             solution(constant(n, 0), HardUnique::kYes, "M is a P-matrix, q >= 0"));
}

// The symmetric part has the eigenvalues 6 + 8 c + 3 (2 c^2 - 1) for c in [-1, 1], at least 1/3.
HardCase make_newton_even(OrderDial<6, 3, 200> n) {
  return planted_ones(circulant(n, 6, 8, 3, n - 1), HardUnique::kYes, "M is positive definite, z = e");
}

// ---- degenerate ----

HardCase make_ones(OrderDial<4, 1, 200> n) {
  return planted(triangular(n, 1, 1, 1), unit(n, 0), constant(n, 0), n > 1 ? HardUnique::kNo : HardUnique::kYes,
                 "M is positive semidefinite; every z >= 0 with sum 1");
}

HardCase make_identity(OrderDial<8, 1, 200> n) {
  return planted_ones(identity(n), HardUnique::kYes, "M = I, z = e");
}

// 1/25 is rounded and 1/50 half of that; of the answer only the price of the last row, 5/2 of 1/50, has to be rounded.
HardCase make_beale(ScaleDial scale) {
  const double small = 1.0 / 25;
  const double half = small / 2;
  const Table A = matrix({{0.25, -60, -small, 9}, {0.5, -90, -half, 3}, {0, 0, 1, 0}});
  const Numbers q{-0.75, 150, -half, 6, 0, 0, 1};
  const Numbers z{small, 0, 1, 0, 0, 1.5, 2.5 * half};
  return with_scale(lcp(skew_blocks(A), q, rounded_solution(z, HardUnique::kYes, "the optimum of Beale's LP")), scale);
}

// min sum |i - j| x_ij, every row and every column covered at least once: x = I costs nothing, so all prices are 0.
HardCase make_assignment(IntegerDial<"k", 4, 1, 20, "rows to assign; n = k^2 + 2 k"> k) {
  Table A(2 * k, k * k);  // A x <= -e
  Numbers cost(k * k);
  Numbers z(k * k + 2 * k);
  for (std::size_t i = 0; i < k; ++i) {
    for (std::size_t j = 0; j < k; ++j) {
      A(i, i * k + j) = A(k + j, i * k + j) = -1;
      cost[i * k + j] = i > j ? static_cast<double>(i - j) : static_cast<double>(j - i);
      if (i == j) z[i * k + j] = 1;
    }
  }
  return lcp(skew_blocks(A), joined(cost, constant(2 * k, -1)),
             solution(z, HardUnique::kNo, "M is skew-symmetric; x = I, prices 0, and any more of x_ii"));
}

// ---- exponential ----

Table murty_matrix(std::size_t n) { return triangular(n, 2, 1, 0); }

using ExponentialDial = OrderDial<12, 1, 25>;

HardCase make_murty(ExponentialDial n) {
  return lcp(murty_matrix(n), constant(n, -1),
             solution(unit(n, 0), HardUnique::kYes, "M is a P-matrix, z = (1, 0, ...)"));
}

HardCase make_murty_nondegenerate(ExponentialDial n) {
  Numbers q(n);
  for (std::size_t i = 0; i < n; ++i) {
    q[i] = (i > 0 ? q[i - 1] : 0) - power_of_two(static_cast<std::int64_t>(n - i));
  }
  return lcp(murty_matrix(n), q,
             solution(scaled(unit(n, 0), power_of_two(n.value)), HardUnique::kYes,
                      "M is a P-matrix, z = (2^n, 0, ...)"));
}

HardCase make_fathi(ExponentialDial n) {
  const Table L = murty_matrix(n);
  return lcp(product(L, transposed(L)), constant(n, -1),
             solution(unit(n, 0), HardUnique::kYes, "M is positive definite, z = (1, 0, ...)"));
}

HardCase make_upper(ExponentialDial n) {
  return lcp(transposed(murty_matrix(n)), constant(n, -1),
             solution(unit(n, n - 1), HardUnique::kYes, "M is a P-matrix, z = (..., 0, 1)"));
}

HardCase make_upper_symmetric(ExponentialDial n) {
  const Table L = murty_matrix(n);
  return lcp(product(transposed(L), L), constant(n, -1),
             solution(unit(n, n - 1), HardUnique::kYes, "M is positive definite, z = (..., 0, 1)"));
}

// max sum 2^(k-j) x_j, sum_{j<i} 2^(i-j+1) x_j + x_i <= 5^i: x = (0, ..., 5^k), and the last row has the price 1.
HardCase make_klee_minty(IntegerDial<"n", 5, 1, 20, "rows of the linear program; the order of M is 2 n"> k) {
  Table A(k, k);
  Numbers cost(k);
  Numbers bound(k);
  double power_of_five = 1;
  for (std::size_t i = 0; i < k; ++i) {
    for (std::size_t j = 0; j < i; ++j) A(i, j) = power_of_two(static_cast<std::int64_t>(i - j) + 1);
    A(i, i) = 1;
    cost[i] = -power_of_two(static_cast<std::int64_t>(k - 1 - i));
    bound[i] = power_of_five *= 5;
  }
  Numbers z(2 * k);
  z[k - 1] = bound[k - 1];
  z[2 * k - 1] = 1;
  return lcp(skew_blocks(A), joined(cost, bound),
             solution(z, HardUnique::kYes, "the optimum of the LP, not degenerate"));
}

HardCase make_csizmadia(OrderDial<16, 1, 200> n) {
  return planted(triangular(n, -1, 1, 0), alternating(n), alternating(n, 1), HardUnique::kYes,
                 "M is a P-matrix, z = (1, 0, 1, ...)");
}

}  // namespace

std::vector<HardSet> pivoting_sets() {
  return {
#include "generators/hard/pivoting.inc"
  };
}

}  // namespace lcpbench::hard
