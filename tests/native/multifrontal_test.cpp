#include "native/velocity_ipm/multifrontal.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "native/kernels/cholesky_engine.h"
#include "native/velocity_ipm/assembly_tree.h"

namespace lcpbench::multifrontal_test {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

using Edges = std::vector<std::pair<int, int>>;  // of a graph, larger vertex first

struct Pattern {
  std::string name;
  int n = 0;
  Edges edges;
};

Edges complete(int first, int end) {
  Edges edges;
  for (int j = first; j < end; ++j) {
    for (int i = j + 1; i < end; ++i) edges.emplace_back(i, j);
  }
  return edges;
}

Edges grid(int side) {
  Edges edges;
  for (int point = 0; point < side * side; ++point) {
    if ((point + 1) % side != 0) edges.emplace_back(point + 1, point);
    if (point + side < side * side) edges.emplace_back(point + side, point);
  }
  return edges;
}

Edges sparse(int n, double density, unsigned seed) {
  std::mt19937 random(seed);
  std::bernoulli_distribution present(density);
  Edges edges;
  for (const auto& edge : complete(0, n)) {
    if (present(random)) edges.push_back(edge);
  }
  return edges;
}

/// Complete graphs of so many vertices each, joined through the last one only.
Edges cliques(int count, int size) {
  const int last = (count - 1) * size;
  Edges edges = complete(last, last + size);
  for (int first = 0; first < last; first += size) {
    for (const auto& edge : complete(first, first + size)) edges.push_back(edge);
    for (int j = first; j < first + size; ++j) {
      for (int i = last; i < last + size; ++i) edges.emplace_back(i, j);
    }
  }
  return edges;
}

/// Sizes on both sides of what kernels deal with at once (4 rows, 64 columns), and graphs of every kind.
std::vector<Pattern> patterns() {
  std::vector<Pattern> all{{"empty", 0, {}}, {"diagonal", 9, {}}, {"two apart", 12, {}}};
  all.back().edges = complete(0, 5);
  const Edges second = complete(5, 12);
  all.back().edges.insert(all.back().edges.end(), second.begin(), second.end());
  for (const int n : {1, 2, 3, 4, 5, 7, 8, 13, 63, 64, 65, 66, 131, 200}) {
    all.push_back({"dense " + std::to_string(n), n, complete(0, n)});
  }
  Pattern forward{"arrow", 40, {}}, backward{"arrow that fills", 40, {}}, chain{"chain", 50, {}};
  for (int i = 0; i < 39; ++i) forward.edges.emplace_back(39, i);
  for (int i = 1; i < 40; ++i) backward.edges.emplace_back(i, 0);
  for (int i = 1; i < 50; ++i) chain.edges.emplace_back(i, i - 1);
  all.insert(all.end(), {forward, backward, chain, {"grid", 400, grid(20)}});
  for (unsigned seed = 0; seed < 30; ++seed) {
    const int n = 10 + 7 * static_cast<int>(seed);
    all.push_back({"random " + std::to_string(seed), n, sparse(n, 0.5 / (seed + 1.0), seed)});
  }
  return all;
}

/// The lower triangle of a symmetric matrix with this pattern, its diagonal entries above the sum of the rest of their
/// rows by a part of it: positive definite, of condition <= 40 whatever the size.
SparseMatrix dominant_matrix(const Pattern& pattern, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-1, 1);
  std::vector<double> diagonal(static_cast<std::size_t>(pattern.n), 0.1);
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& [i, j] : pattern.edges) {
    entries.emplace_back(i, j, value(random));
    for (const int k : {i, j}) diagonal[static_cast<std::size_t>(k)] += 1.1 * std::abs(entries.back().value());
  }
  for (int i = 0; i < pattern.n; ++i) entries.emplace_back(i, i, diagonal[static_cast<std::size_t>(i)]);
  SparseMatrix lower(pattern.n, pattern.n);
  lower.setFromTriplets(entries.begin(), entries.end());
  return lower;
}

Vector random_vector(Index n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-1, 1);
  return Vector::NullaryExpr(n, [&] { return value(random); });
}

Matrix dense(const SparseMatrix& lower) { return Matrix(lower).selfadjointView<Eigen::Lower>(); }

std::vector<IsaLevel> levels() {
  std::vector<IsaLevel> all;
  for (const IsaLevel level : {IsaLevel::kBaseline, IsaLevel::kAvx2, IsaLevel::kAvx512}) {
    if (level <= best_isa_level()) all.push_back(level);
  }
  return all;
}

// Both factorizations are backward stable: they solve A + dA with |dA| <= (3 n + 1) eps |L| |L'|, and |L| |L'| <= n |A|
// in the norm; for dominant matrices it is below 2 |A| [Higham 2002, 10.1]. With condition 40 the solutions are within
// 2 * 40 * 2 (3 n + 1) eps of each other, relative to their size.
TEST(MultifrontalCholeskyTest, SolvesAsDenseCholeskyDoesWhateverThePattern) {
  for (const IsaLevel level : levels()) {
    for (const Pattern& pattern : patterns()) {
      const auto factorization = multifrontal_cholesky(level);
      factorization->analyze(dominant_matrix(pattern, 0));
      for (unsigned values = 1; values <= 3; ++values) {  // the same pattern with other values
        const SparseMatrix lower = dominant_matrix(pattern, values);
        ASSERT_TRUE(factorization->factor(lower)) << pattern.name;
        for (unsigned right_hand_side = 0; right_hand_side < 2; ++right_hand_side) {
          Vector x = random_vector(pattern.n, right_hand_side);
          const Vector reference = dense(lower).llt().solve(x);
          factorization->solve(x);
          ASSERT_LE((x - reference).norm(), 160 * (3 * pattern.n + 1) * kEpsilon * reference.norm())
              << pattern.name << ", level " << to_string(level);
        }
      }
    }
  }
}

TEST(MultifrontalCholeskyTest, BreaksDownOnPivotsThatAreNotPositiveNumbersAndRecovers) {
  for (const IsaLevel level : levels()) {
    for (const Pattern& pattern : patterns()) {
      if (pattern.n == 0) continue;
      const auto factorization = multifrontal_cholesky(level);
      const SparseMatrix good = dominant_matrix(pattern, 1);
      factorization->analyze(good);
      for (const int row : {0, pattern.n / 2, pattern.n - 1}) {
        for (const double bad :
             {-1.0, 0.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1e300}) {
          SparseMatrix lower = good;
          lower.coeffRef(row, row) = bad;
          EXPECT_FALSE(factorization->factor(lower)) << pattern.name << ", row " << row << ": " << bad;
        }
      }
      const Vector b = random_vector(pattern.n, 1);
      Vector x = b;
      ASSERT_TRUE(factorization->factor(good)) << pattern.name;
      factorization->solve(x);
      EXPECT_LE((dense(good) * x - b).norm(), 160 * (3 * pattern.n + 1) * kEpsilon * b.norm()) << pattern.name;
    }
  }
}

/// A matrix with both triangles of its own values, as multifrontal_lu() takes it.
struct Unsymmetric {
  SparseMatrix lower, upper;  // `upper`: of the transpose

  Unsymmetric(const Pattern& pattern, unsigned seed)
      : lower(dominant_matrix(pattern, seed)), upper(dominant_matrix(pattern, seed + 100)) {
    lower.diagonal() += upper.diagonal();  // dominant by rows and by columns
  }
  bool factor_by(UnsymmetricFactorization& factorization) const {
    return factorization.factor(lower.valuePtr(), upper.valuePtr());
  }
  Matrix dense() const {
    return Matrix(lower) + Matrix(Matrix(upper).triangularView<Eigen::StrictlyLower>()).transpose();
  }
};

// Elimination without exchanges of rows is as stable for dominant matrices as Cholesky is: the bound above for both.
TEST(MultifrontalLuTest, SolvesAsDenseLuDoesWhateverThePattern) {
  for (const IsaLevel level : levels()) {
    for (const Pattern& pattern : patterns()) {
      const auto factorization = multifrontal_lu(level);
      factorization->analyze(dominant_matrix(pattern, 0));
      for (unsigned values = 1; values <= 3; ++values) {
        const Unsymmetric matrix(pattern, values);
        ASSERT_TRUE(matrix.factor_by(*factorization)) << pattern.name;
        Vector x = random_vector(pattern.n, values);
        const Vector reference = pattern.n > 0 ? Vector(matrix.dense().partialPivLu().solve(x)) : x;
        factorization->solve(x);
        ASSERT_LE((x - reference).norm(), 160 * (3 * pattern.n + 1) * kEpsilon * reference.norm())
            << pattern.name << ", level " << to_string(level);
      }
    }
  }
}

// Of matrices with zeros on the diagonal. Rows are exchanged within panels of 64 columns of a front, so that the
// factors of larger ones may grow: the residual has eight of sixteen digits.
TEST(MultifrontalLuTest, ExchangesRowsWhereTheDiagonalVanishes) {
  std::vector<Pattern> all;
  for (const int n : {2, 3, 7, 63, 64, 65, 131, 200}) all.push_back({"dense " + std::to_string(n), n, complete(0, n)});
  for (const int size : {2, 5, 70}) all.push_back({"cliques of " + std::to_string(size), 4 * size, cliques(4, size)});
  for (const IsaLevel level : levels()) {
    for (const Pattern& pattern : all) {
      Unsymmetric matrix(pattern, static_cast<unsigned>(pattern.n));
      matrix.lower.diagonal().setZero();
      const auto factorization = multifrontal_lu(level);
      factorization->analyze(matrix.lower);
      ASSERT_TRUE(matrix.factor_by(*factorization)) << pattern.name;
      const Vector b = random_vector(pattern.n, 1);
      Vector x = b;
      factorization->solve(x);
      EXPECT_LE((matrix.dense() * x - b).norm(), 1e-8 * b.norm()) << pattern.name << ", level " << to_string(level);
    }
  }
}

TEST(MultifrontalLuTest, BreaksDownOnSingularMatricesAndNumbersThatAreNotFiniteAndRecovers) {
  for (const IsaLevel level : levels()) {
    for (const Pattern& pattern : patterns()) {
      if (pattern.n == 0) continue;
      const Unsymmetric good(pattern, 1);
      const auto factorization = multifrontal_lu(level);
      factorization->analyze(good.lower);
      const int row = pattern.n / 2;
      constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
      for (const double bad : {0.0, kNan, std::numeric_limits<double>::infinity()}) {
        Unsymmetric matrix = good;
        for (int k = 0; k < pattern.n; ++k) {
          for (SparseMatrix* triangle : {&matrix.lower, &matrix.upper}) {
            for (SparseMatrix::InnerIterator entry(*triangle, k); entry; ++entry) {
              if (entry.row() == row || entry.col() == row) entry.valueRef() = bad;
            }
          }
        }
        EXPECT_FALSE(matrix.factor_by(*factorization)) << pattern.name << ": " << bad;
      }
      const Vector b = random_vector(pattern.n, 1);
      Vector x = b;
      ASSERT_TRUE(good.factor_by(*factorization)) << pattern.name;
      factorization->solve(x);
      EXPECT_LE((good.dense() * x - b).norm(), 160 * (3 * pattern.n + 1) * kEpsilon * b.norm()) << pattern.name;
    }
  }
}

}  // namespace
}  // namespace lcpbench::multifrontal_test
