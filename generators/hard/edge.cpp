#include <cmath>

#include "generators/hard/build.h"

namespace lcpbench::hard {
namespace {

struct ScalarDials {
  double M = 2;
  double q = -3;
  void visit(auto&& field) {
    field("M", M, RealRange{-1e100, 1e100}, "the matrix");
    field("q", q, RealRange{-1e100, 1e100}, "the right-hand side");
  }
};

HardCase make_scalar(const ScalarDials& dials) {
  const Table M = matrix({{dials.M}});
  const Numbers q{dials.q};
  if (dials.q < 0 && dials.M <= 0) return lcp(M, q, unsolvable({1}, "q < 0 and M <= 0"));
  if (dials.q < 0 && !std::isnormal(dials.q / dials.M)) return lcp(M, q, solvable(HardUnique::kYes, "M > 0"));
  if (dials.q < 0) return lcp(M, q, rounded_solution({-dials.q / dials.M}, HardUnique::kYes, "z = -q / M"));
  if (dials.M > 0) return lcp(M, q, solution({0}, HardUnique::kYes, "q >= 0"));
  if (dials.M < 0 && dials.q == 0) return lcp(M, q, solution({0}, HardUnique::kYes, "w = M z >= 0 for z = 0 alone"));
  if (dials.M == 0 && dials.q > 0) return lcp(M, q, solution({0}, HardUnique::kYes, "w = q > 0"));
  return lcp(M, q, solution({0}, HardUnique::kNo, dials.q == 0 ? "every z >= 0" : "z = 0 and z = -q / M"));
}

HardCase make_tiny_pivot(BitsDial<300, 1074> bits) {
  constexpr std::int64_t kLargestExponent = 1023;
  const Table M = matrix({{power_of_two(-bits.value)}});
  if (bits.value > kLargestExponent) return lcp(M, {-1}, solvable(HardUnique::kYes, "z = 2^bits is no double"));
  return lcp(M, {-1}, solution({power_of_two(bits.value)}, HardUnique::kYes, "z = 2^bits"));
}

HardCase make_zero_q(OrderDial<5, 1, 200> n) {
  return lcp(tridiagonal(n, -1, 4, -1), constant(n, 0),
             solution(constant(n, 0), HardUnique::kYes, "q = 0, M is positive definite"));
}

HardCase make_nonnegative_q(OrderDial<3, 1, 200> n) {
  return lcp(triangular(n, 2, -1, -3), constant(n, 1),
             solution(constant(n, 0), HardUnique::kNo, "q >= 0; z = (1, 0, ...) too"));
}

// The row and the column in the middle are zero.
HardCase make_zero_row(OrderDial<3, 1, 200> n) {
  const std::size_t middle = n / 2;
  Table M = tridiagonal(n, -1, 4, -1);
  for (std::size_t i = 0; i < n; ++i) M(i, middle) = M(middle, i) = 0;
  Numbers z = constant(n, 1);
  z[middle] = 0;
  return planted(M, z, constant(n, 0), HardUnique::kNo, "M is positive semidefinite; the middle z is free");
}

HardCase make_zero_matrix(OrderDial<3, 1, 200> n) {
  return lcp(Table(n, n), constant(n, -1), unsolvable(constant(n, 1), "w = q < 0 for every z"));
}

template <std::int64_t kDefault, std::int64_t kMax, int kSign>
struct ScaledDials {
  std::int64_t bits = kDefault;
  std::int64_t n = 6;
  void visit(auto&& field) {
    field("bits", bits, IntegerRange{0, kMax},
          kSign < 0 ? "M is 2^-bits tridiag(-1, 4, -1)" : "M is 2^bits tridiag(-1, 4, -1)");
    field("n", n, IntegerRange{1, 200}, "order of M");
  }
};

/// The same problem at another scale of all of its numbers.
template <std::int64_t kDefault, std::int64_t kMax, int kSign>
HardCase make_scaled(const ScaledDials<kDefault, kMax, kSign>& dials) {
  const double size = power_of_two(kSign * dials.bits);
  return planted_ones(tridiagonal(static_cast<std::size_t>(dials.n), -size, 4 * size, -size), HardUnique::kYes,
                      "M is positive definite, z = e");
}

}  // namespace

std::vector<HardSet> edge_sets() {
  return {
#include "generators/hard/edge.inc"
  };
}

}  // namespace lcpbench::hard
