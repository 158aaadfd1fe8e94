#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "core/contact_problem.h"
#include "core/quad_inertia.h"

namespace lcpbench {
namespace {

/// Largest traces of the inverse of an n x n matrix scaled to unit diagonal that prove what InverseProof demands: the
/// rounding of its factors in double changes eigenvalues by less than n^2 2^-53.
constexpr double kFarFromRounding = 0x1p49;  // over n^2
constexpr double kFarForDigits = 0x1p30;

/// G*, given by its eigenvectors. `independent`: eigenvalues that are far above those that count as zero.
Matrix pseudo_inverse_by_eigenvalues(const Matrix& G, Index& independent) {
  constexpr double kFar = 0x1p20;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(G);
  const Vector& values = eigen.eigenvalues();
  const double cut =
      static_cast<double>(G.rows()) * std::numeric_limits<double>::epsilon() * values.cwiseAbs().maxCoeff();
  Vector inverse(values.size());
  for (Index i = 0; i < values.size(); ++i) inverse(i) = values(i) > cut ? 1.0 / values(i) : 0.0;
  independent = (values.array() > kFar * cut).count();
  return eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

/// G* where factors in double are not proof enough: by factors in 113 bits, rounded, or by eigenvalues where these give
/// no G*.
Matrix precise_inverse(const Inertia& inertia) {
  const QuadInertia precise(inertia);
  if (!precise.well_defined() || precise.is_cut()) {
    Index independent = 0;
    return pseudo_inverse_by_eigenvalues(dense_inertia(inertia), independent);
  }
  const auto n = static_cast<Index>(precise.dimension());
  Matrix inverse(n, n);
  QuadVector column(precise.dimension());
  for (Index j = 0; j < n; ++j) {
    std::fill(column.begin(), column.end(), 0);
    column[static_cast<std::size_t>(j)] = 1;
    precise.solve(column);
    std::transform(column.begin(), column.end(), inverse.col(j).begin(), to_double);
  }
  return inverse;
}

/// By factors in double, where they give the proof.
std::optional<Matrix> inverse_in_double(const Matrix& G, InverseProof proof) {
  const Eigen::LLT<Matrix> llt(G);
  if (llt.info() != Eigen::Success) return std::nullopt;
  Matrix inverse = llt.solve(Matrix::Identity(G.rows(), G.cols()));
  if (!is_far_from_singular(G, inverse, proof)) return std::nullopt;
  return inverse;
}

/// G* of a symmetric G, or of one of its diagonal blocks.
Matrix inverse_of_block(const Matrix& G, InverseProof proof) {
  if (G.rows() == 0) return G;
  if (auto inverse = inverse_in_double(G, proof)) return *std::move(inverse);
  return precise_inverse(DenseInertia{G});
}

/// Whether all coordinates are coupled, and none is so light that the eigenvectors of G lose it.
bool is_of_one_scale(const Matrix& X, const Matrix& G) {
  constexpr double kApart = 0x1p16;
  const Vector sizes = X.rowwise().norm();
  return sizes.maxCoeff() <= kApart * sizes.minCoeff() && G.cwiseAbs().minCoeff() > 0;
}

Matrix inverse_of_factors(const FactoredInertia& inertia, InverseProof proof) {
  const Matrix G = dense_inertia(inertia);
  if (G.rows() == 0) return G;
  if (inertia.X.cols() >= G.rows()) {
    if (auto inverse = inverse_in_double(G, proof)) return *std::move(inverse);
  } else if (is_of_one_scale(inertia.X, G)) {
    Index independent = 0;
    Matrix inverse = pseudo_inverse_by_eigenvalues(G, independent);
    if (independent == inertia.X.cols()) return inverse;
  }
  return precise_inverse(inertia);
}

}  // namespace

bool is_far_from_singular(const Matrix& G, const Matrix& inverse, InverseProof proof) {
  const auto n = static_cast<double>(G.rows());
  const double far = proof == InverseProof::kDigits ? kFarForDigits : kFarFromRounding / (n * n);
  return inverse.diagonal().cwiseProduct(G.diagonal()).sum() <= far;
}

/// A Gram matrix less a part of its diagonal that is far above all rounding has a Cholesky factorization.
bool is_far_from_dependent(const FactoredInertia& inertia, std::vector<double>& work) {
  constexpr double kFar = 0x1p-36;  // n^2 2^-50 is more than the rounding
  constexpr double kApart = 0x1p40;  // of squared lengths
  const Matrix& X = inertia.X;
  const bool by_columns = X.cols() <= X.rows();
  const Index n = std::min(X.rows(), X.cols());
  if (n == 0) return true;
  const double part = std::max(kFar, static_cast<double>(n * n) * 0x1p-50);
  work.resize(static_cast<std::size_t>(n * n + X.rows()));
  Eigen::Map<Matrix> gram(work.data(), n, n);
  Eigen::Map<Eigen::ArrayXd> squared(work.data() + n * n, X.rows());
  squared.setZero();
  for (Index k = 0; k < X.cols(); ++k) squared += X.col(k).array().square();
  double lightest = std::numeric_limits<double>::infinity();
  for (const double length : squared) lightest = length > 0 ? std::min(lightest, length) : lightest;
  if (!(squared.maxCoeff() <= kApart * lightest)) return false;
  if (by_columns) {
    for (Index j = 0; j < n; ++j) {
      for (Index i = 0; i <= j; ++i) gram(i, j) = X.col(i).dot(X.col(j));
    }
  } else {
    gram.setZero();
    for (Index k = 0; k < X.cols(); ++k) {
      const double alpha = inertia.alpha(k);
      for (Index j = 0; j < n; ++j) gram.col(j).head(j + 1) += (alpha * X(j, k)) * X.col(k).head(j + 1);
    }
  }
  double largest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (Index j = 0; j < n; ++j) {
    const double weight = by_columns ? gram(j, j) * inertia.alpha(j) : gram(j, j);
    largest = std::max(largest, weight);
    least = std::min(least, weight);
  }
  if (!(largest <= kApart * least) || !(least > 0)) return false;
  for (Index j = 0; j < n; ++j) {
    double pivot = gram(j, j) - part * (by_columns ? gram(j, j) : largest);
    for (Index i = 0; i < j; ++i) {
      const double entry = (gram(i, j) - gram.col(i).head(i).dot(gram.col(j).head(i))) / gram(i, i);
      gram(i, j) = entry;
      pivot -= entry * entry;
    }
    if (!(pivot > 0)) return false;
    gram(j, j) = std::sqrt(pivot);
  }
  return true;
}

Matrix inverse_inertia(const Inertia& inertia, InverseProof proof) {
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) return inverse_of_block(dense->G, proof);
  if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) return inverse_of_factors(*factors, proof);
  if (const auto* given = std::get_if<InverseInertia>(&inertia)) return given->Ginv;
  BlockInertia inverse;
  for (const Matrix& block : std::get<BlockInertia>(inertia).blocks) {
    inverse.blocks.push_back(inverse_of_block(block, proof));
  }
  return dense_inertia(inverse);
}

}  // namespace lcpbench
