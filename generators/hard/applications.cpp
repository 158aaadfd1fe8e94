#include <algorithm>
#include <cmath>

#include "generators/hard/build.h"

namespace lcpbench::hard {
namespace {

// ---- family ----

HardCase make_geiger_kanzow(OrderDial<32, 1, 200> n) {
  return lcp(tridiagonal(n, -1, 4, -1), constant(n, -1), solvable(HardUnique::kYes, "M is positive definite"));
}

HardCase make_diagonal_ramp(OrderDial<16, 1, 200> n) {
  Table M(n, n);
  Numbers z;
  for (std::size_t i = 0; i < n; ++i) {
    M(i, i) = static_cast<double>(i + 1) / static_cast<double>(n);
    z.push_back(1 / M(i, i));
  }
  return lcp(M, constant(n, -1), rounded_solution(z, HardUnique::kYes, "M is diagonal and positive"));
}

// Small integers that look random and are not.
double scattered(std::size_t i, std::size_t j, std::size_t modulus) {
  return static_cast<double>((7 * i * i + 13 * j + 5 * i * j + 3) % modulus);
}

HardCase make_harker_pang(OrderDial<10, 1, 100> n) {
  Table A(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) A(i, j) = scattered(i, j, 11) - 5;
  }
  Table M = product(A, transposed(A));
  Numbers q(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double skew = scattered(j, i, 13) - 6;
      M(i, j) -= skew;
      M(j, i) += skew;
    }
    M(i, i) += (1 + scattered(i, i, 300)) / 1024;
    q[i] = 0.0 - scattered(i, 2 * i + 1, 501);
  }
  return lcp(M, q, solvable(HardUnique::kYes, "M = A A' + skew + positive diagonal is positive definite"));
}

HardCase make_ahn(OrderDial<64, 1, 200> n) {
  return lcp(tridiagonal(n, 1, 4, -2), constant(n, -4), solvable(HardUnique::kYes, "M is positive definite"));
}

// ---- pde ----

double square(double x) { return x * x; }

/// A membrane u lies on an obstacle or above it, which pushes it up only where they touch: z = u - obstacle >= 0 and
/// w = M u >= 0 with z'w = 0, so that q = M obstacle. @pre M is a P-matrix: the solution is said to be unique
HardCase obstacle_problem(const Table& M, const Numbers& obstacle, const char* reason) {
  return lcp(M, times(M, obstacle), solvable(HardUnique::kYes, reason));
}

HardCase make_string(OddOrderDial<15, 99> n) {
  const auto half = static_cast<double>(n.half);
  Numbers obstacle;
  for (std::size_t i = 0; i < n; ++i) obstacle.push_back(square(half + 1) / 4 - square(static_cast<double>(i) - half));
  return obstacle_problem(tridiagonal(n, -1, 2, -1), obstacle, "M is positive definite");
}

HardCase make_membrane(IntegerDial<"m", 10, 2, 20, "points along a side; n = m^2"> m) {
  Table M(m * m, m * m);
  Numbers obstacle(m * m);
  const double centre = static_cast<double>(m - 1) / 2;
  for (std::size_t x = 0; x < m; ++x) {
    for (std::size_t y = 0; y < m; ++y) {
      const std::size_t i = x * m + y;
      M(i, i) = 4;
      if (x > 0) M(i, i - m) = M(i - m, i) = -1;
      if (y > 0) M(i, i - 1) = M(i - 1, i) = -1;
      obstacle[i] = square(static_cast<double>(m)) -
                    4 * (square(static_cast<double>(x) - centre) + square(static_cast<double>(y) - centre));
    }
  }
  return obstacle_problem(M, obstacle, "M is positive definite");
}

struct BearingDials {
  double eccentricity = 0.5;
  std::int64_t n = 40;
  void visit(auto&& field) {
    field("eccentricity", eccentricity, RealRange{0, 0.999},
          "of the shaft: the film is 1 - eccentricity where it is thinnest");
    field("n", n, IntegerRange{2, 200}, "points around the shaft");
  }
};

/// 1 + eccentricity at the ends, 1 - eccentricity in the middle, a parabola between.
double film(double place, double eccentricity) { return 1 + eccentricity * (2 * square(2 * place - 1) - 1); }

// (h^3 p')' = h', p >= 0. Conductances lie on a grid, so that the diagonal is their exact sum.
HardCase make_bearing(const BearingDials& dials) {
  constexpr double kGrid = 0x1p-40;
  const auto n = static_cast<std::size_t>(dials.n);
  const double step = 1 / static_cast<double>(n + 1);
  Numbers thickness;
  Numbers conductance;
  for (std::size_t i = 0; i <= n; ++i) {
    const double h = film((static_cast<double>(i) + 0.5) * step, dials.eccentricity);
    thickness.push_back(h);
    conductance.push_back(std::max(1.0, std::round(h * h * h / kGrid)) * kGrid);
  }
  Table M(n, n);
  Numbers q(n);
  for (std::size_t i = 0; i < n; ++i) {
    M(i, i) = conductance[i] + conductance[i + 1];
    if (i > 0) M(i, i - 1) = M(i - 1, i) = -conductance[i];
    q[i] = (thickness[i + 1] - thickness[i]) * step;
  }
  return lcp(M, q, solvable(HardUnique::kYes, "M is positive definite"));
}

// One implicit step from the expiry of a put with strike n / 2 on the prices 1, ..., n: squared volatility 1/8,
// rate 1/16, time 1/16; z is the price of the option beyond its payoff.
HardCase make_american_put(OrderDial<40, 2, 200> n) {
  constexpr double kVariance = 1.0 / 8;
  constexpr double kRate = 1.0 / 16;
  constexpr double kTime = 1.0 / 16;
  Table M(n, n);
  Numbers payoff(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto price = static_cast<double>(i + 1);
    M(i, i) = 1 + kTime * (kVariance * square(price) + kRate);
    if (i > 0) M(i, i - 1) = -kTime / 2 * (kVariance * square(price) - kRate * price);
    if (i + 1 < n) M(i, i + 1) = -kTime / 2 * (kVariance * square(price) + kRate * price);
    payoff[i] = std::max(0.0, static_cast<double>(n / 2) - price);
  }
  Numbers q = times(M, payoff);
  for (std::size_t i = 0; i < n; ++i) q[i] -= payoff[i];
  return lcp(M, q, solvable(HardUnique::kYes, "M is strictly diagonally dominant with a positive diagonal"));
}

}  // namespace

std::vector<HardSet> application_sets() {
  return {
#include "generators/hard/applications.inc"
  };
}

}  // namespace lcpbench::hard
