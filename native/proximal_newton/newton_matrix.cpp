#include "native/proximal_newton/newton_matrix.h"

#include <algorithm>
#include <map>
#include <variant>

namespace lcpbench {
namespace {

/// A matrix with more than this part of its entries is factored as a dense one.
constexpr double kDenseShare = 0.3;
/// A pivot on the diagonal is taken if it is not less than that part of the largest of its column.
constexpr double kDiagonalPivot = 1e-3;

using Triplets = std::vector<Eigen::Triplet<double>>;

SparseMatrix with_entries(Index order, const Triplets& entries) {
  SparseMatrix matrix(order, order);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

void NewtonMatrix::load(const Inertia& inertia, const std::vector<ContactRows>& rows) {
  rows_ = &rows;
  Triplets entries;
  const auto add = [&entries](const Matrix& G, Index first) {
    for (Index j = 0; j < G.cols(); ++j) {
      for (Index i = 0; i < G.rows(); ++i) {
        entries.emplace_back(static_cast<int>(first + i), static_cast<int>(first + j), G(i, j));
      }
    }
  };
  if (std::holds_alternative<BlockInertia>(inertia)) {
    for_each_matrix(inertia, add);
  } else {
    add(dense_inertia(inertia), 0);
  }
  const Index order = dimension(inertia);
  G_ = with_entries(order, entries);
  std::map<std::vector<int>, std::size_t> known;
  places_of_.clear();
  for (const ContactRows& own : rows) {
    const auto [found, is_new] = known.try_emplace(own.coordinates, known.size());
    places_of_.push_back(found->second);
    if (!is_new) continue;
    for (const int j : own.coordinates) {
      for (const int i : own.coordinates) entries.emplace_back(i, j, 0.0);
    }
  }
  matrix_ = with_entries(order, entries);
  inertia_ = matrix_.coeffs();
  places_.assign(known.size(), {});
  const int* const inner = matrix_.innerIndexPtr();
  for (const auto& [coordinates, index] : known) {
    for (const int j : coordinates) {
      const int* const first = inner + matrix_.outerIndexPtr()[j];
      const int* const last = inner + matrix_.outerIndexPtr()[j + 1];
      for (const int i : coordinates) {
        places_[index].push_back(static_cast<int>(std::lower_bound(first, last, i) - inner));
      }
    }
  }
  const auto all = static_cast<double>(order) * static_cast<double>(order);
  is_dense_ = static_cast<double>(matrix_.nonZeros()) > kDenseShare * all;
  if (is_dense_) return dense_.resize(order);
  sparse_.setPivotThreshold(kDiagonalPivot);
  sparse_.analyzePattern(matrix_);
}

bool NewtonMatrix::factor(const std::vector<Eigen::Matrix3d>& slopes) {
  auto values = matrix_.coeffs();
  values = inertia_.array();
  work_ = 0;
  for (std::size_t c = 0; c < slopes.size(); ++c) {
    if (!(slopes[c](0, 0) > 0)) continue;
    const Eigen::Matrix3Xd& J = (*rows_)[c].J;
    const int* place = places_[places_of_[c]].data();
    for (Index b = 0; b < J.cols(); ++b) {
      const Eigen::Vector3d moved = slopes[c] * J.col(b);
      for (Index a = 0; a < J.cols(); ++a) values(*place++) += J.col(a).dot(moved);
    }
    work_ += 4 * static_cast<double>(J.cols() * J.cols());
  }
  const auto order = static_cast<double>(G_.cols());
  if (is_dense_) {
    work_ += order * order * order / 3;
    dense_.matrix() = matrix_;
    return dense_.factor();
  }
  sparse_.factorize(matrix_);
  if (sparse_.info() != Eigen::Success) return false;
  work_ += 2 * static_cast<double>(sparse_.nnzL()) * static_cast<double>(sparse_.nnzU()) / order;
  return true;
}

void NewtonMatrix::solve(Vector& x) {
  if (is_dense_) return dense_.solve(x);
  x = sparse_.solve(x).eval();
}

}  // namespace lcpbench
