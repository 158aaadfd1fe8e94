#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <memory>

#include "core/isa.h"
#include "native/kernels/cholesky_engine.h"
#include "native/velocity_ipm/whitened_normals.h"

namespace lcpbench {
namespace {

class DenseNormals final : public WhitenedNormals {
 public:
  explicit DenseNormals(const ContactProblem& problem) : kernels_(cholesky::engine(isa_level())) {
    W_.noalias() = inverse_root(problem.inertia).transpose() * to_dense(problem.N);
    const Index stride = coordinates() + cholesky::kMargin;
    scaled_.setZero(stride, W_.cols());
    matrix_.setZero(stride, stride);
    work_.resize(cholesky::work_size(coordinates()));
  }

  Index coordinates() const override { return W_.rows(); }
  Vector squared_norms() const override { return W_.colwise().squaredNorm(); }
  void combine(const Vector& f, Vector& y) const override { y.noalias() = W_ * f; }
  void project(const Vector& y, Vector& s) const override { s.noalias() = W_.transpose() * y; }
  bool factor(const Vector& weights) override {
    const Index n = coordinates();
    for (Index j = 0; j < W_.cols(); ++j) scaled_.col(j).head(n) = std::sqrt(weights(j)) * W_.col(j);
    return factor_scaled();
  }
  bool factor_coupled(const CoupledCompliance& coupled) override {
    for (const CoupledCompliance::Block& block : coupled.blocks()) {
      const Eigen::Map<const Matrix> root(coupled.root(block), block.size, block.size);
      scaled_.block(0, block.first, coordinates(), block.size).noalias() =
          W_.middleCols(block.first, block.size).lazyProduct(root);
    }
    return factor_scaled();
  }
  bool factor_scaled() {
    const Index n = coordinates();
    matrix_.topLeftCorner(n, n).setIdentity();
    kernels_.add_product(matrix_.data(), matrix_.rows(), scaled_.data(), scaled_.rows(), n, W_.cols(), work_.data());
    return kernels_.factor(matrix_.data(), matrix_.rows(), n, n, work_.data());
  }
  void solve(Vector& y) const override {
    const auto L = matrix_.topLeftCorner(coordinates(), coordinates());
    L.triangularView<Eigen::Lower>().solveInPlace(y);
    L.triangularView<Eigen::Lower>().transpose().solveInPlace(y);
  }
  Cost cost() const override {
    const auto n = static_cast<double>(coordinates());
    const auto columns = static_cast<double>(W_.cols());
    return {.product = 100 + (n + 5) * columns,
            .factor = 500 + n * n * (columns / 8 + n / 24 + 2) + 4 * n * columns,
            .solve = 100 + 2 * n * n + 40 * n};
  }

 private:
  const cholesky::Engine& kernels_;
  Matrix W_;
  Matrix scaled_;  // W weights^(1/2), with the margin of the kernels
  Matrix matrix_;  // lower triangle, likewise
  Vector work_;
};

}  // namespace

Matrix inverse_root(const Inertia& inertia) {
  // S S' = A, or its pseudo-inverse.
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
    for (Index i = 0; i < A.rows(); ++i) {
      if (A(i, i) == 0) S.row(i).setZero();  // A is semidefinite: its row i, and so that of S, is exactly zero
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

std::unique_ptr<WhitenedNormals> dense_whitened_normals(const ContactProblem& problem) {
  return std::make_unique<DenseNormals>(problem);
}

}  // namespace lcpbench
