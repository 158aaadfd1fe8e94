#include "native/lcp_ladder/sparse_pivoting.h"

#include <algorithm>

#include <Eigen/SparseCholesky>

#include "core/timed_solve.h"

namespace lcpbench {
namespace {

/// Block exchanges that may fail to lower the least number of negative variables so far, before single ones begin.
constexpr int kChances = 10;
/// Limit of the nonzeros of all blocks and factors, in multiples of n^2: the work of a few pivots on a dense tableau.
constexpr std::int64_t kWork = 4;
/// Negative z are below minus this part of max|z|, negative w below minus this part of the terms of their sum: far above
/// rounding, far below what the test of answers allows.
constexpr double kZero = 0x1p-40;
/// A diagonal entry is the pivot unless it is smaller than this part of the largest in its column: other pivots change
/// the order, and with it the number of nonzeros.
constexpr double kDiagonalPivot = 0x1p-10;

/// Tells how many nonzeros the factor L of a symmetric matrix will have below its diagonal.
struct SymbolicFactor : Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>> {
  explicit SymbolicFactor(const SparseMatrix& pattern) { analyzePattern(pattern); }
  Index nonzeros() const { return m_matrix.outerIndexPtr()[m_matrix.outerSize()]; }
};

/// M as a sparse matrix. False where it has more than `most` nonzeros, or a diagonal entry that is not positive.
bool find_nonzeros(const Matrix& M, Index most, SparseMatrix& result) {
  std::vector<Eigen::Triplet<double>> entries;
  for (Index j = 0; j < M.cols(); ++j) {
    if (!(M(j, j) > 0)) return false;
    for (Index i = 0; i < M.rows(); ++i) {
      if (M(i, j) != 0) entries.emplace_back(static_cast<int>(i), static_cast<int>(j), M(i, j));
    }
    if (static_cast<Index>(entries.size()) > most) return false;
  }
  result.resize(M.rows(), M.cols());
  result.setFromTriplets(entries.begin(), entries.end());
  return true;
}

}  // namespace

bool SparsePivoting::load(const Lcp& lcp) {
  const Index n = lcp.size();
  const Index most = n * n / kSparse;
  SparseMatrix M;
  if (n < kLeast || !find_nonzeros(lcp.M, most, M)) return false;
  const SparseMatrix pattern = SparseMatrix(M.cwiseAbs()) + SparseMatrix(M.cwiseAbs().transpose());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> from;
  Eigen::AMDOrdering<int>()(pattern, from);
  const Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> to = from.inverse();
  SparseMatrix ordered;
  ordered = pattern.twistedBy(to);
  if (SymbolicFactor(ordered).nonzeros() > most) return false;
  M_ = M.twistedBy(to);
  q_ = to * lcp.q;
  row_.resize(static_cast<std::size_t>(n));
  for (Index i = 0; i < n; ++i) row_[static_cast<std::size_t>(to.indices()(i))] = i;
  sizes_ = M_.cwiseAbs();
  return true;
}

/// z and w of the present basis. False where its block is singular, or z is not finite.
bool SparsePivoting::find_basic_solution() {
  const Index n = q_.size();
  block_.clear();
  std::vector<int> position(static_cast<std::size_t>(n), -1);
  for (Index i = 0; i < n; ++i) {
    if (basic_[static_cast<std::size_t>(i)] == 0) continue;
    position[static_cast<std::size_t>(i)] = static_cast<int>(block_.size());
    block_.push_back(i);
  }
  z_.setZero(n);
  w_ = q_;
  if (block_.empty()) return true;
  const auto size = static_cast<Index>(block_.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (Index j = 0; j < size; ++j) {
    for (SparseMatrix::InnerIterator entry(M_, block_[static_cast<std::size_t>(j)]); entry; ++entry) {
      const int i = position[static_cast<std::size_t>(entry.row())];
      if (i >= 0) entries.emplace_back(i, static_cast<int>(j), entry.value());
    }
  }
  SparseMatrix block(size, size);
  block.setFromTriplets(entries.begin(), entries.end());
  Factors factors;
  factors.isSymmetric(true);
  factors.setPivotThreshold(kDiagonalPivot);
  factors.compute(block);
  ++counts_.factorizations;
  work_ += block.nonZeros();
  if (factors.info() != Eigen::Success) return false;
  work_ += factors.nnzL() + factors.nnzU();
  const Vector right = -q_(block_);
  Vector solution = factors.solve(right);
  solution += factors.solve(Vector(right - block * solution));
  if (!solution.allFinite()) return false;
  z_(block_) = solution;
  w_ += M_ * z_;
  return true;
}

void SparsePivoting::find_negative() {
  const double largest = z_.size() > 0 ? z_.cwiseAbs().maxCoeff() : 0;
  const Vector terms = q_.cwiseAbs() + sizes_ * z_.cwiseAbs();
  negative_.clear();
  for (Index i = 0; i < q_.size(); ++i) {
    const bool is_basic = basic_[static_cast<std::size_t>(i)] != 0;
    const bool negative = is_basic ? z_(i) < -kZero * largest : w_(i) < -kZero * terms(i);
    if (negative) negative_.push_back(i);
  }
}

SparsePivoting::End SparsePivoting::run(double deadline_s, Vector& z) {
  const Index n = q_.size();
  basic_.assign(static_cast<std::size_t>(n), 0);
  counts_ = {};
  work_ = 0;
  std::size_t fewest = static_cast<std::size_t>(n) + 1;
  int chances = kChances;
  for (;;) {
    if (!(wall_clock_s() < deadline_s)) return End::kTimeLimit;
    if (work_ > kWork * n * n) return End::kWorkLimit;
    if (!find_basic_solution()) return End::kSingular;
    ++counts_.steps;
    find_negative();
    if (negative_.empty()) break;
    if (negative_.size() < fewest) {
      fewest = negative_.size();
      chances = kChances;
    } else if (chances > 0) {
      --chances;
    } else {
      negative_.erase(negative_.begin(), negative_.end() - 1);
      ++counts_.single;
    }
    counts_.exchanges += static_cast<std::int64_t>(negative_.size());
    for (const Index i : negative_) basic_[static_cast<std::size_t>(i)] ^= 1;
  }
  for (Index i = 0; i < n; ++i) z(row_[static_cast<std::size_t>(i)]) = z_(i);
  return End::kSolved;
}

}  // namespace lcpbench
