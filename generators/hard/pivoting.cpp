#include "generators/hard/build.h"

namespace lcpbench::hard {
namespace {

// ---- cycling ----

/// Row i has `diagonal` in column i, `first` in i + step and `second` in i + 2 step, cyclically.
Square circulant(std::size_t n, double diagonal, double first, double second, std::size_t step) {
  Square M(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    M(i, i) += diagonal;
    M(i, (i + step) % n) += first;
    M(i, (i + 2 * step) % n) += second;
  }
  return M;
}

HardCase make_kostreva(const ScaleDial& dial) {
  return with_scale(
      planted(circulant(3, 1, 2, 0, 1), constant(3, 1), constant(3, 0), HardUnique::kYes, "M is a P-matrix, z = e"),
      dial);
}

HardCase make_morris(const OddOrderDial<2, 100>& dial) {
  const std::size_t n = dial.order();
  return planted(circulant(n, 1, 2, 0, 1), constant(n, 1), constant(n, 0), HardUnique::kYes, "M is a P-matrix, z = e");
}

HardCase make_newton_odd(const OddOrderDial<3, 100>& dial) {
  const std::size_t n = dial.order();
  return lcp(circulant(n, 1, 2, 0, n - 1), constant(n, 1),
             solution(constant(n, 0), HardUnique::kYes, "M is a P-matrix, q >= 0"));
}

// The symmetric part has the eigenvalues 6 + 8 c + 3 (2 c^2 - 1) for c in [-1, 1], at least 1/3.
HardCase make_newton_even(const OrderDial<6, 3, 200>& dial) {
  const auto n = static_cast<std::size_t>(dial.n);
  return planted(circulant(n, 6, 8, 3, n - 1), constant(n, 1), constant(n, 0), HardUnique::kYes,
                 "M is positive definite, z = e");
}

// ---- degenerate ----

HardCase make_ones(const OrderDial<4, 1, 200>& dial) {
  const auto n = static_cast<std::size_t>(dial.n);
  return planted(triangular(n, 1, 1, 1), unit(n, 0), constant(n, 0), n > 1 ? HardUnique::kNo : HardUnique::kYes,
                 "M is positive semidefinite; every z >= 0 with sum 1");
}

HardCase make_identity(const OrderDial<8, 1, 200>& dial) {
  const auto n = static_cast<std::size_t>(dial.n);
  return planted(identity(n), constant(n, 1), constant(n, 0), HardUnique::kYes, "M = I, z = e");
}

// 1/25 is rounded and 1/50 half of that; of the answer only the price of the last row, 5/2 of 1/50, has to be rounded.
HardCase make_beale(const ScaleDial& dial) {
  const double small = 1.0 / 25;
  const double half = small / 2;
  const Square A = matrix({{0.25, -60, -small, 9}, {0.5, -90, -half, 3}, {0, 0, 1, 0}});
  const Numbers q{-0.75, 150, -half, 6, 0, 0, 1};
  const Numbers z{small, 0, 1, 0, 0, 1.5, 2.5 * half};
  return with_scale(lcp(skew_blocks(A), q, rounded_solution(z, HardUnique::kYes, "the optimum of Beale's LP")), dial);
}

struct AssignmentDials {
  std::int64_t k = 4;
  void visit(auto&& field) { field("k", k, IntegerRange{1, 20}, "rows to assign; n = k^2 + 2 k"); }
};

// min sum |i - j| x_ij, every row and every column covered at least once: x = I costs nothing, so all prices are 0.
HardCase make_assignment(const AssignmentDials& dials) {
  const auto k = static_cast<std::size_t>(dials.k);
  Square A(2 * k, k * k);  // A x <= -e
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

Square murty_matrix(std::int64_t order) { return triangular(static_cast<std::size_t>(order), 2, 1, 0); }

using ExponentialDial = OrderDial<12, 1, 25>;

HardCase make_murty(const ExponentialDial& dial) {
  const auto n = static_cast<std::size_t>(dial.n);
  return lcp(murty_matrix(dial.n), constant(n, -1),
             solution(unit(n, 0), HardUnique::kYes, "M is a P-matrix, z = (1, 0, ...)"));
}

HardCase make_murty_nondegenerate(const ExponentialDial& dial) {
  const auto n = static_cast<std::size_t>(dial.n);
  Numbers q(n);
  for (std::size_t i = 0; i < n; ++i) {
    q[i] = (i > 0 ? q[i - 1] : 0) - power_of_two(dial.n - static_cast<std::int64_t>(i));
  }
  return lcp(
      murty_matrix(dial.n), q,
      solution(scaled(unit(n, 0), power_of_two(dial.n)), HardUnique::kYes, "M is a P-matrix, z = (2^n, 0, ...)"));
}

HardCase make_fathi(const ExponentialDial& dial) {
  const auto n = static_cast<std::size_t>(dial.n);
  const Square L = murty_matrix(dial.n);
  return lcp(product(L, transposed(L)), constant(n, -1),
             solution(unit(n, 0), HardUnique::kYes, "M is positive definite, z = (1, 0, ...)"));
}

HardCase make_upper(const ExponentialDial& dial) {
  const auto n = static_cast<std::size_t>(dial.n);
  return lcp(transposed(murty_matrix(dial.n)), constant(n, -1),
             solution(unit(n, n - 1), HardUnique::kYes, "M is a P-matrix, z = (..., 0, 1)"));
}

HardCase make_upper_symmetric(const ExponentialDial& dial) {
  const auto n = static_cast<std::size_t>(dial.n);
  const Square L = murty_matrix(dial.n);
  return lcp(product(transposed(L), L), constant(n, -1),
             solution(unit(n, n - 1), HardUnique::kYes, "M is positive definite, z = (..., 0, 1)"));
}

// max sum 2^(k-j) x_j, sum_{j<i} 2^(i-j+1) x_j + x_i <= 5^i: x = (0, ..., 5^k), and the last row has the price 1.
HardCase make_klee_minty(const OrderDial<5, 1, 20>& dial) {
  const auto k = static_cast<std::size_t>(dial.n);
  Square A(k, k);
  Numbers cost(k);
  Numbers bound(k);
  double power_of_five = 1;
  for (std::size_t i = 0; i < k; ++i) {
    for (std::size_t j = 0; j < i; ++j) A(i, j) = power_of_two(static_cast<std::int64_t>(i - j) + 1);
    A(i, i) = 1;
    cost[i] = -power_of_two(dial.n - 1 - static_cast<std::int64_t>(i));
    bound[i] = power_of_five *= 5;
  }
  Numbers z(2 * k);
  z[k - 1] = bound[k - 1];
  z[2 * k - 1] = 1;
  return lcp(skew_blocks(A), joined(cost, bound),
             solution(z, HardUnique::kYes, "the optimum of the LP, not degenerate"));
}

HardCase make_csizmadia(const OrderDial<16, 1, 200>& dial) {
  const auto n = static_cast<std::size_t>(dial.n);
  const Numbers z = alternating(n);
  Numbers w(n);
  for (std::size_t i = 0; i < n; ++i) w[i] = 1 - z[i];
  return planted(triangular(n, -1, 1, 0), z, w, HardUnique::kYes, "M is a P-matrix, z = (1, 0, 1, ...)");
}

constexpr const char* kMurtySource = "Murty 1978, Computational complexity of complementary pivot methods";
constexpr const char* kFathiSource =
    "Fathi 1979, Computational complexity of LCPs associated with positive definite symmetric matrices";
constexpr const char* kNewtonSource =
    "Ben Gharbia and Gilbert 2012, Nonconvergence of the plain Newton-min algorithm for linear complementarity "
    "problems "
    "with a P-matrix";

void add_cycling(std::vector<HardSet>& sets) {
  sets.push_back(
      hard_set<ScaleDial, make_kostreva>({"cycling/kostreva", "n = 3", "circulant (1, 2, 0), q = -3 e",
                                          "Lemke's method with first-index ties cycles for ever on this P-matrix",
                                          "Kostreva 1979, Cycling in linear complementarity problems"}));
  sets.push_back(hard_set<OddOrderDial<2, 100>, make_morris>(
      {"cycling/morris", "n = 3..201, odd", "I + 2 times the cyclic shift, q = -3 e",
       "highly cyclic: the random-edge rule takes a number of pivots that is exponential in n",
       "Morris 2002, Randomized pivot algorithms for P-matrix linear complementarity problems"}));
  sets.push_back(hard_set<OddOrderDial<3, 100>, make_newton_odd>(
      {"cycling/newton-odd", "n = 3..201, odd", "I + 2 times the inverse cyclic shift, q = e",
       "z = 0 solves it; Newton-min methods that begin anywhere else may cycle", kNewtonSource}));
  sets.push_back(hard_set<OrderDial<6, 3, 200>, make_newton_even>(
      {"cycling/newton-even", "n = 3..200", "circulant of 6, 8, 3 behind the diagonal, q = -17 e",
       "Newton-min methods cycle; nonsymmetric, so that no function descends", kNewtonSource}));
}

void add_degenerate(std::vector<HardSet>& sets) {
  sets.push_back(hard_set<OrderDial<4, 1, 200>, make_ones>(
      {"degenerate/ones", "n = 1..200", "M = e e', q = -e",
       "rank one: every ratio test ties, every pivot but one is singular", "by hand"}));
  sets.push_back(hard_set<OrderDial<8, 1, 200>, make_identity>(
      {"degenerate/identity", "n = 1..200", "M = I, q = -e",
       "all first ratios tie; the order of n exchanges is the tie rule's", "by hand"}));
  sets.push_back(
      hard_set<ScaleDial, make_beale>({"degenerate/beale", "n = 7", "Beale's linear program as a skew-symmetric LCP",
                                       "the simplex method with the largest coefficient cycles; a path of zero steps",
                                       "Beale 1955, Cycling in the dual simplex algorithm"}));
  sets.push_back(hard_set<AssignmentDials, make_assignment>(
      {"degenerate/assignment", "n = 3..440",
       "an assignment problem with the costs abs(i - j), as a skew-symmetric LCP",
       "2 k active rows share k^2 columns: most bases are degenerate and most steps are zero", "by hand"}));
}

void add_exponential(std::vector<HardSet>& sets) {
  sets.push_back(hard_set<ExponentialDial, make_murty>(
      {"exponential/murty", "n = 1..25", "unit lower triangle with 2 below, q = -e",
       "lexicographic Lemke takes 2^n pivots, other tie rules one; Murty's least-index method 2^n - 1 in one order",
       kMurtySource}));
  sets.push_back(hard_set<ExponentialDial, make_murty_nondegenerate>(
      {"exponential/murty-nondegenerate", "n = 1..25", "the same M, q_i = -(2^n + ... + 2^(n-i+1))",
       "no ties: Lemke's method with the covering vector e has to take 2^n pivots", kMurtySource}));
  sets.push_back(hard_set<ExponentialDial, make_fathi>(
      {"exponential/fathi", "n = 1..25", "L L' of the same L, q = -e",
       "the same path of 2^n pivots on a symmetric positive definite matrix", kFathiSource}));
  sets.push_back(hard_set<ExponentialDial, make_upper>(
      {"exponential/upper", "n = 1..25", "unit upper triangle with 2 above, q = -e",
       "principal pivoting by least index or most negative entry takes 2^n - 1 pivots", kMurtySource}));
  sets.push_back(hard_set<ExponentialDial, make_upper_symmetric>(
      {"exponential/upper-symmetric", "n = 1..25", "U U' of the same U, q = -e",
       "the same on a symmetric positive definite matrix", kFathiSource}));
  sets.push_back(hard_set<OrderDial<5, 1, 20>, make_klee_minty>(
      {"exponential/klee-minty", "n = 2..40", "a linear program of n rows, as a skew-symmetric LCP of 2 n",
       "the simplex path visits all 2^n corners; right-hand sides up to 5^n",
       "Klee and Minty 1972, How good is the simplex algorithm?"}));
  sets.push_back(hard_set<OrderDial<16, 1, 200>, make_csizmadia>(
      {"exponential/csizmadia", "n = 1..200", "1 on the diagonal, -1 below, solution (1, 0, 1, ...)",
       "the inverse has entries up to 2^(n-2): the handicap of M, and with it the bound on interior-point steps, is "
       "exponential",
       "Csizmadia, in de Klerk and E.-Nagy 2011, On the complexity of computing the handicap of a sufficient matrix"}));
}

}  // namespace

void add_pivoting_sets(std::vector<HardSet>& sets) {
  add_cycling(sets);
  add_degenerate(sets);
  add_exponential(sets);
}

}  // namespace lcpbench::hard
