#include "native/principal_pivoting/principal_tableau.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace lcpbench {

void PrincipalTableau::load(Lcp lcp) {
  lcp_ = std::move(lcp);
  const Index n = size();
  rows_.resize(2, n);
  columns_.resize(n, 2);
  work_.resize(n);
  magnitude_.resize(n);
  z_is_basic_.resize(static_cast<std::size_t>(n));
  wanted_.resize(static_cast<std::size_t>(n));
  reset();
}

void PrincipalTableau::reset() {
  M_ = lcp_.M;
  q_ = lcp_.q;
  std::fill(z_is_basic_.begin(), z_is_basic_.end(), char{false});
  pivots_since_rebuild_ = 0;
}

template <std::size_t K>
void PrincipalTableau::exchange(const std::array<Index, K>& pairs) {
  constexpr int kSize = static_cast<int>(K);
  const auto pair = [&pairs](int a) { return pairs[static_cast<std::size_t>(a)]; };
  Eigen::Matrix<double, kSize, kSize> block;
  Eigen::Matrix<double, kSize, 1> constants;
  auto rows = rows_.topRows<kSize>();
  auto columns = columns_.leftCols<kSize>();
  for (int a = 0; a < kSize; ++a) {
    constants(a) = q_(pair(a));
    for (int b = 0; b < kSize; ++b) block(a, b) = M_(pair(a), pair(b));
    rows.row(a) = M_.row(pair(a));
    columns.col(a) = M_.col(pair(a));
  }
  const Eigen::Matrix<double, kSize, kSize> inverse = block.inverse();
  const Eigen::Matrix<double, kSize, 1> new_constants = -(inverse * constants);
  for (Index j = 0; j < size(); ++j) {
    const Eigen::Matrix<double, kSize, 1> row = -(inverse * rows.col(j));
    rows.col(j) = row;
    for (int a = 0; a < kSize; ++a) M_.col(j) += row(a) * columns.col(a);
  }
  for (int a = 0; a < kSize; ++a) q_ += new_constants(a) * columns.col(a);
  for (int b = 0; b < kSize; ++b) {
    auto column = M_.col(pair(b));
    column.setZero();
    for (int a = 0; a < kSize; ++a) column += inverse(a, b) * columns.col(a);
  }
  for (int a = 0; a < kSize; ++a) {
    M_.row(pair(a)) = rows.row(a);
    q_(pair(a)) = new_constants(a);
    char& z_is_basic = z_is_basic_[static_cast<std::size_t>(pair(a))];
    z_is_basic = !z_is_basic;
  }
  for (int a = 0; a < kSize; ++a) {
    for (int b = 0; b < kSize; ++b) M_(pair(a), pair(b)) = inverse(a, b);
  }
  ++pivots_since_rebuild_;
}

/// One step of rebuild(): the best pivot among the pairs of wanted_ that are still to be exchanged. False where all of
/// them are zero.
bool PrincipalTableau::pivot_largest() {
  // A 2 x 2 pivot grows the entries by at most as much as two 1 x 1 pivots when the larger diagonal entry is below
  // 0.64 of the largest entry. [Bunch, Parlett 1971]
  constexpr double kGrowth = 0.64;
  const auto remains = [&](Index i) { return wanted_[static_cast<std::size_t>(i)] && !z_is_basic(i); };
  double largest_diagonal = 0;
  double largest_determinant = 0;
  Index single = -1;
  std::pair<Index, Index> couple{-1, -1};
  for (Index j = 0; j < size(); ++j) {
    if (!remains(j)) continue;
    if (std::abs(M_(j, j)) > largest_diagonal) {
      largest_diagonal = std::abs(M_(j, j));
      single = j;
    }
    for (Index i = 0; i < j; ++i) {
      if (!remains(i) || !(std::abs(determinant(i, j)) > largest_determinant)) continue;
      largest_determinant = std::abs(determinant(i, j));
      couple = {i, j};
    }
  }
  if (single >= 0 && largest_diagonal >= kGrowth * std::sqrt(largest_determinant)) {
    pivot(single);
  } else if (couple.first >= 0) {
    pivot(couple.first, couple.second);
  } else {
    return false;
  }
  return true;
}

bool PrincipalTableau::rebuild() {
  wanted_ = z_is_basic_;
  reset();
  while (z_is_basic_ != wanted_) {
    if (!pivot_largest()) return false;
  }
  pivots_since_rebuild_ = 0;
  return q_.allFinite() && M_.allFinite();
}

void PrincipalTableau::constant_errors(double relative, Vector& bounds) {
  magnitude_ = lcp_.q.cwiseAbs();
  errors_of_solve(q_, relative, bounds);
}

void PrincipalTableau::column_errors(Index j, double relative, Vector& bounds) {
  if (z_is_basic(j)) {
    magnitude_.setZero();
    magnitude_(j) = 1;  // w_j is a right-hand side of its row
  } else {
    magnitude_ = lcp_.M.col(j).cwiseAbs();
  }
  errors_of_solve(M_.col(j), relative, bounds);
}

bool PrincipalTableau::gains(Index j, double relative) {
  for (Index i = 0; i < size(); ++i) work_(i) = z_is_basic(i) ? M_(i, j) : i == j ? 1 : 0;
  double gain = 0;
  double size_of_terms = 0;
  for (Index i = 0; i < size(); ++i) {
    if (work_(i) == 0) continue;
    const auto column = lcp_.M.col(i);
    gain += work_(i) * column.dot(work_);
    size_of_terms += std::abs(work_(i)) * column.cwiseAbs().dot(work_.cwiseAbs());
  }
  return gain > relative * size_of_terms;
}

/// `solution` solves the rows of the basic z; magnitude_ is |its right-hand side|. The residual that the errors of the
/// data leave in each row is multiplied by the inverse. [Higham 2002, (7.26)]
void PrincipalTableau::errors_of_solve(const Eigen::Ref<const Vector>& solution, double relative, Vector& bounds) {
  for (Index j = 0; j < size(); ++j) {
    if (z_is_basic(j)) magnitude_ += std::abs(solution(j)) * lcp_.M.col(j).cwiseAbs();
  }
  bounds.setZero();
  for (Index j = 0; j < size(); ++j) {
    if (z_is_basic(j)) {
      bounds += magnitude_(j) * M_.col(j).cwiseAbs();
    } else {
      bounds(j) += magnitude_(j);
    }
  }
  bounds *= relative;
}

void PrincipalTableau::solution(Vector& z) {
  constexpr int kRefinements = 2;
  z.setZero();
  for (Index j = 0; j < size(); ++j) {
    if (z_is_basic(j)) z(j) = q_(j);
  }
  for (int step = 0; step < kRefinements; ++step) {
    work_ = lcp_.q;
    work_.noalias() += lcp_.M * z;  // w: in the rows of the basic z the residual
    for (Index j = 0; j < size(); ++j) {
      if (!z_is_basic(j)) continue;
      for (Index i = 0; i < size(); ++i) {
        if (z_is_basic(i)) z(i) -= M_(i, j) * work_(j);
      }
    }
  }
  z = z.cwiseMax(0.0);
}

}  // namespace lcpbench
