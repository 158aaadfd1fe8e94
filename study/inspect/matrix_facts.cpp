#include "study/inspect/matrix_facts.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

namespace lcpbench {
namespace {

double asymmetry(const Matrix& M) {
  const double largest = M.size() > 0 ? M.cwiseAbs().maxCoeff() : 0;
  if (!(largest > 0)) return 0;
  return (M / largest - M.transpose() / largest).cwiseAbs().maxCoeff();
}

double nonzero_condition(const Spectrum& scaled) {
  return std::max(std::abs(scaled.largest), std::abs(scaled.smallest)) / scaled.smallest_nonzero;
}

Index impossible_rows(const Matrix& M, const Vector& q) {
  Index count = 0;
  for (Index i = 0; i < q.size(); ++i) {
    if (q(i) < 0 && M.row(i).maxCoeff() <= 0) ++count;
  }
  return count;
}

/// Row k reads [mu >= 0 .. -1 .. -1 .. 0] and column k [0 .. 1 .. 1 .. 0], the ones in the places of the minus ones.
bool is_cone(const Matrix& M, Index k) {
  if (M(k, k) != 0) return false;
  Index ones = 0;
  for (Index j = 0; j < M.rows(); ++j) {
    if (M(k, j) < 0) {
      if (M(k, j) != -1 || M(j, k) != 1) return false;
      ++ones;
    } else if (M(j, k) != 0) {
      return false;
    }
  }
  return ones >= 2 && ones % 2 == 0;
}

Index count_cones(const Matrix& M) {
  Index count = 0;
  for (Index k = 0; k < M.rows(); ++k) count += is_cone(M, k) ? 1 : 0;
  return count;
}

void add_sizes(const Matrix& M, MatrixFacts& facts) {
  for (Index i = 0; i < M.rows(); ++i) {
    const double row = M.row(i).cwiseAbs().maxCoeff();
    if (row == 0) ++facts.zero_rows;
    facts.row_sizes.add(row);
    facts.column_sizes.add(M.col(i).cwiseAbs().maxCoeff());
    facts.diagonal.add(std::abs(M(i, i)));
    if (M(i, i) < 0) ++facts.negative_diagonal;
    facts.least_diagonal = std::min(facts.least_diagonal, M(i, i));
    for (Index j = 0; j < M.cols(); ++j) facts.entries.add(std::abs(M(i, j)));
  }
}

/// Semidefinite or without a negative entry: copositive. A negative value on one or two coordinates: not.
void add_classes(const Matrix& M, MatrixFacts& facts) {
  facts.z_matrix = is_z_matrix(M);
  facts.p_matrix = is_p_matrix(M);
  facts.not_copositive_at = copositivity_counterexample(M);
  if (facts.not_copositive_at) {
    facts.copositive = Tri::kNo;
  } else if (M.size() == 0 || M.minCoeff() >= 0 || facts.symmetric.positive_definite()) {
    facts.copositive = Tri::kYes;
  }
}

Matrix symmetric_part(const Matrix& M, const std::vector<Index>& rows) {
  const Matrix A = M(rows, rows);
  return A / 2 + A.transpose() / 2;
}

}  // namespace

std::pair<Index, Index> island_sizes(const RowIslands& islands, Index rows) {
  std::vector<Index> sizes(static_cast<std::size_t>(islands.count), 0);
  for (Index row = 0; row < rows; ++row) {
    ++sizes[static_cast<std::size_t>(islands.of_row[static_cast<std::size_t>(row)])];
  }
  return {islands.count, sizes.empty() ? 0 : *std::max_element(sizes.begin(), sizes.end())};
}

MatrixFacts matrix_facts(const Lcp& lcp, const std::vector<Index>& independent) {
  MatrixFacts facts;
  facts.dense = true;
  facts.asymmetry = asymmetry(lcp.M);
  const Matrix symmetric = symmetric_part(lcp.M, independent);
  facts.symmetric = spectrum_of(symmetric);
  facts.condition = nonzero_condition(spectrum_of(unit_diagonal(symmetric)));
  facts.rank = {rank_of_doubles(lcp.M), numerical_rank(lcp.M, 0x1p-50 * static_cast<double>(lcp.size()))};
  add_sizes(lcp.M, facts);
  add_classes(lcp.M, facts);
  facts.impossible_rows = impossible_rows(lcp.M, lcp.q);
  facts.impossible_rows_transposed = impossible_rows(lcp.M.transpose(), lcp.q);
  facts.impossible_rows_negated = impossible_rows(-lcp.M, lcp.q);
  facts.cone_rows = count_cones(lcp.M);
  facts.cone_rows_transposed = count_cones(lcp.M.transpose());
  std::tie(facts.islands, facts.largest_island) = island_sizes(row_islands(lcp.M), lcp.M.rows());
  return facts;
}

VelocityFacts velocity_facts(const Vector& q, Index rows, const Matrix& M) {
  VelocityFacts facts;
  facts.not_pressed = M.rows() == q.size() ? 0 : -1;
  for (Index i = 0; i < rows; ++i) {
    ++(q(i) < 0 ? facts.negative : q(i) > 0 ? facts.positive : facts.zero);
    facts.least = i == 0 ? q(i) : std::min(facts.least, q(i));
    facts.largest_magnitude = std::max(facts.largest_magnitude, std::abs(q(i)));
    if (facts.not_pressed >= 0 && q(i) > 0 && M.row(i).minCoeff() >= 0) ++facts.not_pressed;
  }
  const Index ties = (q.head(rows).array() == facts.least).count();
  facts.ties = facts.least < 0 && ties > 1 ? ties : 0;
  return facts;
}

}  // namespace lcpbench
