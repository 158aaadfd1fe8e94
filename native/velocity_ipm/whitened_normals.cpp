#include "native/velocity_ipm/whitened_normals.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "native/velocity_ipm/nested_dissection.h"

namespace lcpbench {
namespace {

/// S (ngc x rank) with S S' = G*.
Matrix inverse_root(const Inertia& inertia) {
  const auto of_eigenvalues = [](const Matrix& A, bool inverse) {
    const Eigen::SelfAdjointEigenSolver<Matrix> eigen(A);
    const Vector& values = eigen.eigenvalues();
    const double cut =
        static_cast<double>(A.rows()) * std::numeric_limits<double>::epsilon() * values.cwiseAbs().maxCoeff();
    Matrix S(A.rows(), 0);
    for (Index i = 0; i < values.size(); ++i) {
      if (!(values(i) > cut)) continue;
      S.conservativeResize(Eigen::NoChange, S.cols() + 1);
      S.col(S.cols() - 1) = eigen.eigenvectors().col(i) * std::sqrt(inverse ? 1 / values(i) : values(i));
    }
    return S;
  };
  if (dimension(inertia) == 0) return Matrix(0, 0);
  if (const auto* given = std::get_if<InverseInertia>(&inertia)) return of_eigenvalues(given->Ginv, false);
  const Matrix G = dense_inertia(inertia);
  const auto* factors = std::get_if<FactoredInertia>(&inertia);
  const Eigen::LLT<Matrix> llt(G);
  if (llt.info() != Eigen::Success || (factors != nullptr && factors->X.cols() < factors->X.rows())) {
    return of_eigenvalues(G, true);
  }
  return llt.matrixU().solve(Matrix::Identity(G.rows(), G.cols()));
}

class DenseNormals final : public WhitenedNormals {
 public:
  explicit DenseNormals(const ContactProblem& problem) : S_(inverse_root(problem.inertia)) {
    W_.noalias() = S_.transpose() * to_dense(problem.N);
    scaled_.resize(W_.rows(), W_.cols());
    matrix_.resize(W_.rows(), W_.rows());
  }

  Index coordinates() const override { return W_.rows(); }
  Vector squared_norms() const override { return W_.colwise().squaredNorm(); }
  void combine(const Vector& f, Vector& y) const override { y.noalias() = W_ * f; }
  void project(const Vector& y, Vector& s) const override { s.noalias() = W_.transpose() * y; }
  bool factor(const Vector& weights) override {
    scaled_.noalias() = W_ * weights.cwiseSqrt().asDiagonal();
    matrix_.setIdentity();
    matrix_.selfadjointView<Eigen::Lower>().rankUpdate(scaled_);
    factor_.compute(matrix_);
    return factor_.info() == Eigen::Success;
  }
  void solve(Vector& y) const override { factor_.solveInPlace(y); }
  void velocity(const Vector& v, const Vector& y, Vector& u) const override {
    u = v;
    u.noalias() += S_ * y;
  }

 private:
  Matrix S_;
  Matrix W_;
  Matrix scaled_;
  Matrix matrix_;
  Eigen::LLT<Matrix> factor_;
};

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

class SparseNormals final : public WhitenedNormals {
 public:
  SparseNormals(BlockRoots roots, const Jacobian& N, std::unique_ptr<SparseFactorization> factorization)
      : roots_(std::move(roots)), W_(roots_.whiten(sparse(N))), factorization_(std::move(factorization)) {
    matrix_ = pattern();
    const std::vector<int> order = nested_dissection(matrix_);
    position_of_.resize(W_.rows());
    for (std::size_t k = 0; k < order.size(); ++k) {
      position_of_.indices()(order[k]) = static_cast<int>(k);
    }
    W_ = (position_of_ * W_).eval();
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
    u = position_of_.transpose() * y;
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
  Eigen::PermutationMatrix<Eigen::Dynamic> position_of_;  // of each coordinate in the order of elimination
  SparseMatrix W_;                                        // rows in the order of elimination
  SparseMatrix matrix_;                                   // lower triangle
  std::vector<Index> diagonal_;
  std::vector<Index> position_;
  std::unique_ptr<SparseFactorization> factorization_;
};

}  // namespace

std::unique_ptr<WhitenedNormals> dense_whitened_normals(const ContactProblem& problem) {
  return std::make_unique<DenseNormals>(problem);
}

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
