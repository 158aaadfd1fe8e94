#include "native/velocity_ipm/whitened_normals.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>
#include <vector>

#include "native/velocity_ipm/nested_dissection.h"

namespace lcpbench {
namespace {

/// Factors of the blocks of an inertia: G = L L', block by block.
class BlockRoots {
 public:
  /// False when a block is not positive definite.
  bool factor(const BlockInertia& inertia) {
    for (const Matrix& block : inertia.blocks) {
      factors_.emplace_back(block);
      if (factors_.back().info() != Eigen::Success) return false;
      begin_.push_back(size());
      block_of_row_.insert(block_of_row_.end(), static_cast<std::size_t>(block.rows()), factors_.size() - 1);
    }
    return true;
  }

  Index size() const { return static_cast<Index>(block_of_row_.size()); }

  /// L^-1 N, column by column over the blocks that it touches.
  SparseMatrix whiten(const SparseMatrix& N) const {
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(static_cast<std::size_t>(N.nonZeros()));
    Vector part;
    for (Index j = 0; j < N.outerSize(); ++j) {
      for (SparseMatrix::InnerIterator entry(N, j); entry;) {
        const std::size_t block = block_of_row_[static_cast<std::size_t>(entry.row())];
        const Index first = begin_[block];
        part.setZero(factors_[block].rows());
        for (; entry && block_of_row_[static_cast<std::size_t>(entry.row())] == block; ++entry) {
          part(entry.row() - first) += entry.value();
        }
        factors_[block].matrixL().solveInPlace(part);
        for (Index i = 0; i < part.size(); ++i) {
          if (part(i) != 0) entries.emplace_back(static_cast<int>(first + i), static_cast<int>(j), part(i));
        }
      }
    }
    SparseMatrix W(N.rows(), N.cols());
    W.setFromTriplets(entries.begin(), entries.end());
    return W;
  }

  /// x := L^-T x.
  void solve_transposed(Vector& x) const {
    for (std::size_t b = 0; b < factors_.size(); ++b) {
      auto part = x.segment(begin_[b], factors_[b].rows());
      factors_[b].matrixU().solveInPlace(part);
    }
  }

 private:
  std::vector<Eigen::LLT<Matrix>> factors_;
  std::vector<Index> begin_;
  std::vector<std::size_t> block_of_row_;
};

SparseMatrix sparse(const Jacobian& J) {
  if (const auto* dense = std::get_if<Matrix>(&J)) return dense->sparseView();
  SparseMatrix compressed = std::get<SparseMatrix>(J);
  compressed.makeCompressed();
  return compressed;
}

/// The rows of W that have entries: the others are coordinates that no contact changes.
std::vector<int> touched_rows(const SparseMatrix& W) {
  std::vector<char> touched(static_cast<std::size_t>(W.rows()), 0);
  for (Index e = 0; e < W.nonZeros(); ++e) touched[static_cast<std::size_t>(W.innerIndexPtr()[e])] = 1;
  std::vector<int> rows;
  for (std::size_t i = 0; i < touched.size(); ++i) {
    if (touched[i] != 0) rows.push_back(static_cast<int>(i));
  }
  return rows;
}

/// The rows of W listed, in that order. @pre the others are empty
SparseMatrix rows_of(const SparseMatrix& W, const std::vector<int>& rows) {
  std::vector<int> position(static_cast<std::size_t>(W.rows()), -1);
  for (std::size_t k = 0; k < rows.size(); ++k) position[static_cast<std::size_t>(rows[k])] = static_cast<int>(k);
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(W.nonZeros()));
  for (Index j = 0; j < W.outerSize(); ++j) {
    for (SparseMatrix::InnerIterator entry(W, j); entry; ++entry) {
      entries.emplace_back(position[static_cast<std::size_t>(entry.row())], static_cast<int>(j), entry.value());
    }
  }
  SparseMatrix chosen(static_cast<Index>(rows.size()), W.cols());
  chosen.setFromTriplets(entries.begin(), entries.end());
  return chosen;
}

/// Coordinates that no contact changes are left out.
class SparseNormals final : public WhitenedNormals {
 public:
  SparseNormals(BlockRoots roots, const Jacobian& N, std::unique_ptr<SparseFactorization> factorization)
      : roots_(std::move(roots)), factorization_(std::move(factorization)) {
    const SparseMatrix W = roots_.whiten(sparse(N));
    const std::vector<int> touched = touched_rows(W);
    W_ = rows_of(W, touched);
    for (const int row : nested_dissection(pattern())) rows_.push_back(touched[static_cast<std::size_t>(row)]);
    W_ = rows_of(W, rows_);
    matrix_ = pattern();
    find_positions();
    factorization_->analyze(matrix_);
  }

  Index coordinates() const override { return W_.rows(); }
  Vector squared_norms() const override {
    Vector norms(W_.cols());
    for (Index j = 0; j < W_.cols(); ++j) norms(j) = W_.col(j).squaredNorm();
    return norms;
  }
  void combine(const Vector& f, Vector& y) const override { y.noalias() = W_ * f; }
  void project(const Vector& y, Vector& s) const override { s.noalias() = W_.transpose() * y; }

  bool factor(const Vector& weights) override {
    double* values = matrix_.valuePtr();
    std::fill(values, values + matrix_.nonZeros(), 0.0);
    for (const Index diagonal : diagonal_) values[diagonal] = 1;
    std::size_t product = 0;
    for (Index j = 0; j < W_.cols(); ++j) {
      for (SparseMatrix::InnerIterator b(W_, j); b; ++b) {
        const double weighted = weights(j) * b.value();
        for (SparseMatrix::InnerIterator a = b; a; ++a) values[position_[product++]] += weighted * a.value();
      }
    }
    return factorization_->factor(matrix_);
  }
  void solve(Vector& y) const override { factorization_->solve(y); }
  void velocity(const Vector& v, const Vector& y, Vector& u) const override {
    u.setZero(v.size());
    for (std::size_t k = 0; k < rows_.size(); ++k) u(rows_[k]) = y(static_cast<Index>(k));
    roots_.solve_transposed(u);
    u += v;
  }

 private:
  /// The lower triangle of I + W W'.
  SparseMatrix pattern() const {
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < static_cast<int>(W_.rows()); ++i) entries.emplace_back(i, i, 1.0);
    for (Index j = 0; j < W_.cols(); ++j) {
      for (SparseMatrix::InnerIterator b(W_, j); b; ++b) {
        for (SparseMatrix::InnerIterator a = b; a; ++a) {
          entries.emplace_back(static_cast<int>(a.row()), static_cast<int>(b.row()), 1.0);
        }
      }
    }
    SparseMatrix matrix(W_.rows(), W_.rows());
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
  }

  /// Where the diagonal is in matrix_, and where each product of two entries of a column of W goes.
  void find_positions() {
    const auto position = [&](Index row, Index column) {
      const int* begin = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[column];
      const int* end = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[column + 1];
      return static_cast<Index>(std::lower_bound(begin, end, static_cast<int>(row)) - matrix_.innerIndexPtr());
    };
    for (Index i = 0; i < W_.rows(); ++i) diagonal_.push_back(position(i, i));
    for (Index j = 0; j < W_.cols(); ++j) {
      for (SparseMatrix::InnerIterator b(W_, j); b; ++b) {
        for (SparseMatrix::InnerIterator a = b; a; ++a) position_.push_back(position(a.row(), b.row()));
      }
    }
  }

  BlockRoots roots_;
  std::vector<int> rows_;  // the coordinates that contacts change, in the order of elimination
  SparseMatrix W_;         // their rows
  SparseMatrix matrix_;    // lower triangle
  std::vector<Index> diagonal_;
  std::vector<Index> position_;
  std::unique_ptr<SparseFactorization> factorization_;
};

}  // namespace

std::unique_ptr<WhitenedNormals> sparse_whitened_normals(const ContactProblem& problem,
                                                         std::unique_ptr<SparseFactorization> factorization) {
  BlockRoots roots;
  const auto* blocks = std::get_if<BlockInertia>(&problem.inertia);
  if (blocks == nullptr || !roots.factor(*blocks)) return nullptr;
  return std::make_unique<SparseNormals>(std::move(roots), problem.N, std::move(factorization));
}

bool wants_sparse(Algebra algebra, const ContactProblem& problem) {
  if (algebra != Algebra::kAuto) return algebra == Algebra::kSparse;
  return std::holds_alternative<SparseMatrix>(problem.N) && std::holds_alternative<BlockInertia>(problem.inertia);
}

}  // namespace lcpbench
