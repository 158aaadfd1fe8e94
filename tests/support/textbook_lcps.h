#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/lcp.h"
#include "core/solver.h"

namespace lcpbench {

/// How GoogleTest shows a claim.
inline void PrintTo(Claim claim, std::ostream* out) { *out << to_string(claim); }

}  // namespace lcpbench

namespace lcpbench::testing {

/// A linear complementarity problem of the literature whose answer is known.
struct TextbookLcp {
  std::string name;
  std::string source;
  Lcp lcp;
  bool solvable = true;
  bool unique = false;    ///< then z is its solution
  bool monotone = false;  ///< M + M' positive semidefinite
  Vector z;               ///< a solution; empty where there is none
};

inline void PrintTo(const TextbookLcp& textbook, std::ostream* out) {
  *out << textbook.name << " (" << textbook.source << ")";
}

inline Vector vector_of(std::initializer_list<double> values) {
  Vector v(static_cast<Index>(values.size()));
  std::copy(values.begin(), values.end(), v.data());
  return v;
}

inline Matrix matrix_of(Index n, std::initializer_list<double> row_major) {
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(row_major.begin(), n,
                                                                                                  n);
}

inline Vector ones(Index n) { return Vector::Ones(n); }

/// Unit lower triangular with 2 below the diagonal. [Murty 1978]
inline Matrix murty_matrix(Index n) {
  Matrix L = Matrix::Identity(n, n);
  for (Index j = 0; j < n; ++j) L.col(j).tail(n - j - 1).setConstant(2.0);
  return L;
}

/// a on the diagonal, b and c on the next two circulant superdiagonals.
inline Matrix circulant(Index n, double a, double b, double c) {
  Matrix M = Matrix::Zero(n, n);
  for (Index i = 0; i < n; ++i) {
    M(i, i) += a;
    M(i, (i + 1) % n) += b;
    M(i, (i + 2) % n) += c;
  }
  return M;
}

inline Matrix tridiagonal(Index n, double diagonal, double off) {
  Matrix M = Matrix::Zero(n, n);
  if (n == 0) return M;
  M.diagonal().setConstant(diagonal);
  M.diagonal(1).setConstant(off);
  M.diagonal(-1).setConstant(off);
  return M;
}

/// Hilbert matrix times the least common multiple of its denominators: exact integers for n <= 10.
inline Matrix integer_hilbert_matrix(Index n) {
  double multiple = 1;
  for (Index k = 2; k < 2 * n; ++k) {
    double a = multiple, b = static_cast<double>(k);
    while (b != 0) a = std::exchange(b, std::fmod(a, b));
    multiple *= static_cast<double>(k) / a;
  }
  Matrix M(n, n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) M(i, j) = multiple / static_cast<double>(i + j + 1);
  }
  return M;
}

inline TextbookLcp unique_case(std::string name, std::string source, Matrix M, Vector q, Vector z,
                               bool monotone = true) {
  return {std::move(name), std::move(source), {std::move(M), std::move(q)}, true, true, monotone, std::move(z)};
}

inline TextbookLcp ambiguous_case(std::string name, std::string source, Matrix M, Vector q, Vector z, bool monotone) {
  return {std::move(name), std::move(source), {std::move(M), std::move(q)}, true, false, monotone, std::move(z)};
}

inline TextbookLcp unsolvable_case(std::string name, std::string source, Matrix M, Vector q, bool monotone) {
  return {std::move(name), std::move(source), {std::move(M), std::move(q)}, false, false, monotone, Vector()};
}

inline std::vector<TextbookLcp> textbook_lcps() {
  const std::string cps = "Cottle, Pang, Stone 1992";
  Matrix horn = circulant(5, 1, -1, 1);
  horn = (horn + horn.transpose()).eval();
  horn.diagonal().setOnes();
  Vector first(8), first12(12);
  first.setZero();
  first12.setZero();
  first(0) = first12(0) = 1;
  const Matrix murty8 = murty_matrix(8);
  const Matrix hilbert = integer_hilbert_matrix(8);
  return {
      unique_case("one_variable_basic", cps + " 1.1", matrix_of(1, {2}), vector_of({-3}), vector_of({1.5})),
      unique_case("one_variable_trivial", cps + " 1.1", matrix_of(1, {2}), vector_of({3}), vector_of({0})),
      ambiguous_case("one_variable_two_solutions", cps + " 3.1", matrix_of(1, {-1}), vector_of({1}), vector_of({1}),
                     false),
      unsolvable_case("one_variable_negative", cps + " 3.1", matrix_of(1, {-1}), vector_of({-1}), false),
      unsolvable_case("one_variable_zero_matrix", cps + " 3.1", matrix_of(1, {0}), vector_of({-1}), true),
      ambiguous_case("one_variable_all_zero", cps + " 3.1", matrix_of(1, {0}), vector_of({0}), vector_of({0}), true),
      ambiguous_case("rank_one_continuum", cps + " 3.1: solutions z >= 0 with sum 1", Matrix::Ones(4, 4), -ones(4),
                     ones(4) / 4, true),
      ambiguous_case("ball_between_plates", "solutions (1 + t, t): the inner force is free",
                     matrix_of(2, {1, -1, -1, 1}), vector_of({-1, 1}), vector_of({1, 0}), true),
      unsolvable_case("ball_crushed_by_plates", "u = (1, 1) proves it: M'u = 0, q'u < 0", matrix_of(2, {1, -1, -1, 1}),
                      vector_of({-1, -1}), true),
      unique_case("barely_feasible", "as above, feasible by 2^-40", matrix_of(2, {1, -1, -1, 1}),
                  vector_of({-1, 1 + 0x1p-40}), vector_of({1, 0})),
      unsolvable_case("feasible_without_solution", cps + " 3.7: copositive, not plus", matrix_of(2, {2, 0, 1, 0}),
                      vector_of({-2, -2}), false),
      unique_case("copositive_not_plus", cps + " 3.7: Lemke's method with covering vector e ends on a ray",
                  matrix_of(2, {0, 1, 1, 0}), vector_of({-2, -2}), vector_of({2, 2}), false),
      ambiguous_case("copositive_continuum", cps + " 3.7: solutions (2, t)", matrix_of(2, {1, 0, 1, 0}),
                     vector_of({-2, -2}), vector_of({2, 0}), false),
      ambiguous_case("singular_support", "solutions (t, 0), t >= 1, and (1, s): z_0 is basic on a zero pivot",
                     matrix_of(2, {0, 0, 1, 0}), vector_of({0, -1}), vector_of({1, 0}), false),
      ambiguous_case("n_matrix_three_solutions", "Kojima, Saigal 1979", matrix_of(2, {-1, 2, 2, -1}), vector_of({1, 1}),
                     vector_of({0, 0}), false),
      unique_case("n_matrix_one_solution", "Kojima, Saigal 1979", matrix_of(2, {-1, 2, 2, -1}), vector_of({-1, -1}),
                  vector_of({1, 1}), false),
      unique_case("horn", "Hall, Newman 1963: copositive, no sum of a semidefinite and a nonnegative matrix", horn,
                  -ones(5), ones(5), false),
      unique_case("kostreva", "Kostreva 1979: least-index Lemke cycles", circulant(3, 1, 2, 0), -ones(3), ones(3) / 3),
      unique_case("morris", "Morris 2002", circulant(5, 1, 2, 0), -ones(5), ones(5) / 3, false),
      unique_case("murty_8", "Murty 1978: 2^n pivots", murty8, -ones(8), first),
      unique_case("murty_12", "Murty 1978: 2^n pivots", murty_matrix(12), -ones(12), first12),
      unique_case("fathi_8", "Fathi 1979: positive definite, 2^n pivots", murty8 * murty8.transpose(), -ones(8), first),
      unique_case("identity", "all ratios tie", Matrix::Identity(8, 8), -ones(8), ones(8)),
      unique_case("geiger_kanzow", "Geiger, Kanzow 1996", tridiagonal(3, 4, -1), -ones(3),
                  vector_of({5.0 / 14, 6.0 / 14, 5.0 / 14})),
      unique_case("hilbert_8", "condition number 1e10", hilbert, -hilbert * ones(8), ones(8)),
  };
}

/// max_i |min(c_i z_i, w_i)| / max|q|, c_i the largest |entry| of column i of M: the units of w throughout. Infinity
/// for a z that is not finite or has the wrong length; the absolute value where q is zero.
inline double relative_residual(const Lcp& lcp, const Vector& z) {
  if (z.size() != lcp.size() || !z.allFinite()) return std::numeric_limits<double>::infinity();
  if (z.size() == 0) return 0;
  const Vector w = lcp.M * z + lcp.q;
  const Vector scaled = lcp.M.cwiseAbs().colwise().maxCoeff().transpose().cwiseProduct(z);
  const double worst = w.cwiseMin(scaled).cwiseAbs().maxCoeff();
  const double scale = lcp.q.cwiseAbs().maxCoeff();
  return scale > 0 ? worst / scale : worst;
}

/// Numbers uniform on [-1, 1), the same on every platform.
class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : bits_(seed) {}
  double operator()() { return static_cast<double>(bits_() >> 11) * 0x1p-52 - 1; }
  std::int64_t integer(std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(bits_() % static_cast<std::uint64_t>(high - low + 1));
  }
  Vector vector(Index n) {
    Vector v(n);
    for (Index i = 0; i < n; ++i) v(i) = (*this)();
    return v;
  }
  Matrix matrix(Index rows, Index cols) {
    Matrix M(rows, cols);
    for (Index j = 0; j < cols; ++j) M.col(j) = vector(rows);
    return M;
  }

 private:
  std::mt19937_64 bits_;
};

/// Klee and Minty's linear program of order m, max c'x, A x <= b, as the LCP of its optimality conditions.
inline Lcp klee_minty(Index m) {
  Matrix A = Matrix::Zero(m, m);
  Vector b(m), c(m);
  for (Index i = 0; i < m; ++i) {
    for (Index j = 0; j < i; ++j) A(i, j) = std::ldexp(1.0, static_cast<int>(i - j + 1));
    A(i, i) = 1;
    b(i) = std::pow(5.0, static_cast<double>(i + 1));
    c(i) = std::ldexp(1.0, static_cast<int>(m - i - 1));
  }
  Lcp lcp{Matrix::Zero(2 * m, 2 * m), Vector(2 * m)};
  lcp.M.topRightCorner(m, m) = A.transpose();
  lcp.M.bottomLeftCorner(m, m) = -A;
  lcp.q << -c, b;
  return lcp;
}

/// q that makes z = t+ with w = t- a solution.
inline Lcp plant(Matrix M, const Vector& t, Vector& z) {
  z = t.cwiseMax(0.0);
  Vector q = (-t).cwiseMax(0.0) - M * z;
  return {std::move(M), std::move(q)};
}

}  // namespace lcpbench::testing
