#include "generators/hard/build.h"

namespace lcpbench::hard {
namespace {

// ---- ray ----

HardCase scaled_lcp(const Table& M, const Numbers& q, HardTruth truth, ScaleDial scale) {
  return with_scale(lcp(M, q, std::move(truth)), scale);
}

HardCase make_ray_solvable(ScaleDial scale) {
  return scaled_lcp(matrix({{0, 1}, {1, 0}}), {-2, -2}, solution({2, 2}, HardUnique::kYes, "z = (2, 2), by cases"),
                    scale);
}

HardCase make_ray_none(ScaleDial scale) {
  return scaled_lcp(matrix({{2, 0}, {1, 0}}), {-2, -2},
                    unsolvable({}, "w >= 0 asks for z_1 >= 2, then w_1 > 0 asks for z_1 = 0"), scale);
}

HardCase make_ray_continuum(ScaleDial scale) {
  return scaled_lcp(matrix({{1, 0}, {1, 0}}), {-2, -2},
                    solution({2, 0}, HardUnique::kNo, "z = (2, t) for every t >= 0"), scale);
}

HardCase make_ray_indefinite(ScaleDial scale) {
  return scaled_lcp(matrix({{1, 0}, {1, -2}}), {-2, -2}, solution({2, 0}, HardUnique::kYes, "z = (2, 0), by cases"),
                    scale);
}

HardCase make_ray_infeasible(ScaleDial scale) {
  return scaled_lcp(matrix({{1, -1}, {-1, 1}}), {-1, -1}, unsolvable({1, 1}, "w_1 + w_2 = -2 for every z"), scale);
}

HardCase make_barely_feasible(BitsDial<40, 52> bits) {
  return lcp(matrix({{1, -1}, {-1, 1}}), {-1, 1 + power_of_two(-bits.value)},
             solution({1, 0}, HardUnique::kYes, "w_1 + w_2 = 2^-bits"));
}

HardCase make_barely_infeasible(BitsDial<20, 52> bits) {
  return lcp(matrix({{1, -1}, {-1, 1}}), {-1, 1 - power_of_two(-bits.value)},
             unsolvable({1, 1}, "w_1 + w_2 = -2^-bits for every z"));
}

// ---- class ----

HardCase make_horn(ScaleDial scale) {
  Table M(5, 5);
  constexpr double kRow[] = {1, -1, 1, 1, -1};
  for (std::size_t i = 0; i < 5; ++i) {
    for (std::size_t j = 0; j < 5; ++j) M(i, j) = kRow[(j + 5 - i) % 5];
  }
  return with_scale(planted_ones(M, HardUnique::kYes, "z = e, by cases"), scale);
}

HardCase make_n_matrix(ScaleDial scale) {
  return scaled_lcp(matrix({{-1, 2}, {2, -1}}), {1, 1}, solution({0, 0}, HardUnique::kNo, "z = 0, (1, 0), (0, 1)"),
                    scale);
}

HardCase make_n_matrix_negative(ScaleDial scale) {
  return scaled_lcp(matrix({{-1, 2}, {2, -1}}), {-1, -1}, solution({1, 1}, HardUnique::kYes, "z = e, by cases"), scale);
}

HardCase make_isolated(ScaleDial scale) {
  return scaled_lcp(matrix({{0, -1, -1}, {1, 0, 0}, {-1, 0, 0}}), {0, -1, 1},
                    solution({1, 0, 0}, HardUnique::kYes, "w_1 asks for z_2 = z_3 = 0, w_2 and w_3 for z_1 = 1"),
                    scale);
}

HardCase make_isolated_transposed(ScaleDial scale) {
  return scaled_lcp(matrix({{0, 1, -1}, {-1, 0, 0}, {-1, 0, 0}}), {0, -1, 1},
                    unsolvable({0, 1, 0}, "w_2 < 0 for every z"), scale);
}

struct ShearDials {
  double shear = 4;
  void visit(auto&& field) { field("shear", shear, RealRange{1, 1e15}, "t of M = [1 t; 0 1]"); }
};

HardCase make_shear(const ShearDials& dials) {
  return lcp(matrix({{1, dials.shear}, {0, 1}}), {-1, -1},
             solution({0, 1}, HardUnique::kYes, "M is a P-matrix, z = (0, 1)"));
}

// In each block w = (z_2 - 1, 1 - z_1), so that z'w = z_2 - z_1.
HardCase make_skew(IntegerDial<"blocks", 4, 1, 100, "n = 2 blocks"> blocks) {
  const std::size_t n = 2 * blocks;
  Table M(n, n);
  for (std::size_t i = 0; i < n; i += 2) {
    M(i, i + 1) = 1;
    M(i + 1, i) = -1;
  }
  return planted_ones(M, HardUnique::kYes, "z_2 >= 1 >= z_1 and z_2 = z_1 in each block");
}

// ---- game ----

/// [0 A; B' 0] for two players with the costs A (of the one who chooses the row) and B. Its LCP has q = -e.
Table bimatrix(const Table& A, const Table& B) {
  const std::size_t m = A.rows;
  Table M(m + A.cols, m + A.cols);
  for (std::size_t i = 0; i < m; ++i) {
    for (std::size_t j = 0; j < A.cols; ++j) {
      M(i, m + j) = A(i, j);
      M(m + j, i) = B(i, j);
    }
  }
  return M;
}

HardCase make_battle(ScaleDial scale) {
  return scaled_lcp(bimatrix(matrix({{1, 3}, {3, 2}}), matrix({{2, 3}, {3, 1}})), constant(4, -1),
                    solution({0.5, 0, 1, 0}, HardUnique::kNo, "three equilibria"), scale);
}

HardCase make_coordination(IntegerDial<"strategies", 3, 2, 60, "of each player; n = 2 strategies"> k) {
  const Table cost = triangular(k, 2, 1, 2);
  return lcp(bimatrix(cost, cost), constant(2 * k, -1),
             solution(joined(unit(k, 0), unit(k, 0)), HardUnique::kNo, "2^strategies - 1 equilibria"));
}

// Row sums of the payoffs are 0, so that playing every strategy equally often is an equilibrium; it is the only one.
HardCase make_cyclic(IntegerDial<"half", 1, 1, 30, "each player has 2 half + 1 strategies"> half) {
  const std::size_t k = 2 * half + 1;
  Table rows(k, k);
  Table columns(k, k);
  for (std::size_t i = 0; i < k; ++i) {
    for (std::size_t j = 0; j < k; ++j) {
      const std::size_t ahead = (j + k - i) % k;
      const double payoff = ahead == 0 ? 0 : ahead <= k / 2 ? 1 : -1;
      rows(i, j) = 2 - payoff;
      columns(i, j) = 2 + payoff;
    }
  }
  return planted_ones(bimatrix(rows, columns), HardUnique::kYes,
                      "a zero-sum game with one completely mixed equilibrium");
}

}  // namespace

std::vector<HardSet> class_sets() {
  return {
#include "generators/hard/classes.inc"
  };
}

}  // namespace lcpbench::hard
