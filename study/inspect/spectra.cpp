#include "study/inspect/spectra.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "study/certify/integers.h"
#include "study/output/json_output.h"

namespace lcpbench {
namespace {

constexpr int kMostSweeps = 60;  // convergence is quadratic: ten are plenty

Quad off_diagonal_square(const QuadMatrix& A) {
  Quad sum = 0;
  for (std::size_t i = 0; i < A.rows; ++i) {
    for (std::size_t j = 0; j < i; ++j) sum += 2 * A(i, j) * A(i, j);
  }
  return sum;
}

Quad frobenius_square(const QuadMatrix& A) {
  Quad sum = off_diagonal_square(A);
  for (std::size_t i = 0; i < A.rows; ++i) sum += A(i, i) * A(i, i);
  return sum;
}

/// Makes A_pq zero by a rotation of rows and columns p and q; only the lower triangle is kept up.
void rotate(QuadMatrix& A, std::size_t p, std::size_t q) {
  const auto entry = [&A](std::size_t i, std::size_t j) -> Quad& { return i > j ? A(i, j) : A(j, i); };
  const Quad apq = entry(p, q);
  if (apq == 0) return;
  const Quad theta = (A(q, q) - A(p, p)) / (2 * apq);
  const Quad magnitude = 1 / (abs(theta) + sqrt(theta * theta + 1));
  const Quad t = theta < 0 ? -magnitude : magnitude;
  const Quad c = 1 / sqrt(t * t + 1);
  const Quad s = t * c;
  A(p, p) -= t * apq;
  A(q, q) += t * apq;
  entry(p, q) = 0;
  for (std::size_t k = 0; k < A.rows; ++k) {
    if (k == p || k == q) continue;
    const Quad akp = entry(k, p);
    const Quad akq = entry(k, q);
    entry(k, p) = c * akp - s * akq;
    entry(k, q) = s * akp + c * akq;
  }
}

Matrix in_double(const QuadMatrix& A) {
  const auto entry = [&](Index i, Index j) {
    return to_double(A(static_cast<std::size_t>(i), static_cast<std::size_t>(j)));
  };
  return Matrix::NullaryExpr(static_cast<Index>(A.rows), static_cast<Index>(A.cols), entry);
}

Spectrum summarize(const std::vector<double>& ascending, double rounding) {
  Spectrum spectrum;
  spectrum.rounding = rounding;
  spectrum.rank = 0;
  spectrum.smallest = ascending.empty() ? 0 : ascending.front();
  spectrum.largest = ascending.empty() ? 0 : ascending.back();
  for (const double value : ascending) {
    if (!(std::abs(value) > rounding)) continue;
    ++spectrum.rank;
    spectrum.smallest_nonzero =
        std::isnan(spectrum.smallest_nonzero) ? std::abs(value) : std::min(spectrum.smallest_nonzero, std::abs(value));
  }
  return spectrum;
}

/// The eigenvalues computed are those of a matrix that differs by a modest multiple of n eps in norm. [Wilkinson 1965]
Spectrum spectrum_in_double(const Matrix& A, double formation_error) {
  if (!A.allFinite()) return {};
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(A, Eigen::EigenvaluesOnly);
  const Vector& values = solver.eigenvalues();
  const double relative = 8 * std::numeric_limits<double>::epsilon() + formation_error;
  const double rounding = static_cast<double>(A.rows()) * relative * A.stableNorm();
  return summarize(std::vector<double>(values.begin(), values.end()), rounding);
}

/// Singular values above `relative` times the largest, of A with columns scaled to length 1; 0 without nonzero columns.
Index numerical_rank(const Matrix& A, double relative) {
  if (A.size() == 0) return 0;
  // The eigenvalues of [0 A; A' 0] are the singular values of A, their negatives, and zeros.
  const Index rows = A.rows();
  Matrix both = Matrix::Zero(rows + A.cols(), rows + A.cols());
  both.bottomLeftCorner(A.cols(), rows) = unit_columns(A).transpose();  // the solver reads the lower triangle
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(both, Eigen::EigenvaluesOnly);
  const Vector& values = solver.eigenvalues();
  return (values.array() > relative * values(values.size() - 1)).count();
}

const char* definiteness(const Spectrum& spectrum) {
  if (spectrum.rank == 0) return "zero to rounding";
  if (spectrum.positive_definite()) return "positive definite";
  if (spectrum.may_be_semidefinite()) return "positive semidefinite to rounding";
  if (spectrum.largest < -spectrum.rounding) return "negative definite";
  return spectrum.largest <= spectrum.rounding ? "negative semidefinite to rounding" : "indefinite";
}

/// Ascending, by Jacobi's cyclic rotations: six to ten sweeps of O(n^3).
QuadVector eigenvalues(QuadMatrix A) {
  const Quad done = frobenius_square(A) * Quad{0x1p-230};
  for (int sweep = 0; sweep < kMostSweeps && off_diagonal_square(A) > done; ++sweep) {
    for (std::size_t q = 1; q < A.rows; ++q) {
      for (std::size_t p = 0; p < q; ++p) rotate(A, p, q);
    }
  }
  QuadVector values(A.rows);
  for (std::size_t i = 0; i < A.rows; ++i) values[i] = A(i, i);
  std::sort(values.begin(), values.end());
  return values;
}

}  // namespace

void Range::add(double magnitude) {
  if (!(magnitude > 0)) return;
  low = std::fmin(low, magnitude);
  high = std::fmax(high, magnitude);
}

Json range_json(const Range& range) {
  return {{"low", json_number(range.low)}, {"high", json_number(range.high)}};
}

Json spectrum_json(const Spectrum& spectrum) {
  return {{"definiteness", spectrum.rank < 0 ? Json() : Json(definiteness(spectrum))},
          {"smallest", json_number(spectrum.smallest)},
          {"largest", json_number(spectrum.largest)},
          {"rounding", json_number(spectrum.rounding)},
          {"smallest_nonzero", json_number(spectrum.smallest_nonzero)},
          {"rank", json_count(spectrum.rank)}};
}

Json rank_json(const Matrix& A, const Matrix& in_units, double visible) {
  return {{"exact", A.allFinite() ? Json(rank_of_doubles(A)) : Json()},
          {"visible", in_units.allFinite() ? Json(numerical_rank(in_units, visible)) : Json()}};
}

double nonzero_condition(const Spectrum& spectrum) {
  return std::max(std::abs(spectrum.largest), std::abs(spectrum.smallest)) / spectrum.smallest_nonzero;
}

/// By way of the largest entry, so that no square overflows.
Matrix unit_columns(Matrix A) {
  for (Index j = 0; j < A.cols(); ++j) {
    const double largest = A.rows() > 0 ? A.col(j).cwiseAbs().maxCoeff() : 0.0;
    if (!(largest > 0)) continue;
    A.col(j) /= largest;
    A.col(j) /= A.col(j).norm();
  }
  return A;
}

Spectrum spectrum_of(const QuadMatrix& A, double formation_error) {
  if (A.rows > kLargestQuad) return spectrum_in_double(in_double(A), formation_error);
  if (!std::all_of(A.entries.begin(), A.entries.end(), is_finite)) return {};
  const QuadVector values = eigenvalues(A);
  // Each rotation errs by a few units of the Frobenius norm; an entry is touched by 2n rotations a sweep.
  const auto n = static_cast<double>(A.rows);
  const double norm = to_double(sqrt(frobenius_square(A)));
  const double rounding = (128 * n * kQuadUnitRoundoff + n * formation_error) * norm;
  return summarize(std::vector<double>(values.begin(), values.end()), rounding);
}

Spectrum spectrum_of(const Matrix& A) {
  return A.rows() > kLargestQuad ? spectrum_in_double(A, 0) : spectrum_of(QuadMatrix(A), 0);
}

QuadMatrix unit_diagonal(const QuadMatrix& A) {
  QuadVector scale(A.rows);
  for (std::size_t i = 0; i < A.rows; ++i) scale[i] = A(i, i) > 0 ? 1 / sqrt(A(i, i)) : Quad{0};
  QuadMatrix scaled = A;
  for (std::size_t i = 0; i < A.rows; ++i) {
    for (std::size_t j = 0; j < A.cols; ++j) scaled(i, j) *= scale[i] * scale[j];
  }
  return scaled;
}

Index rank_of_doubles(const Matrix& A) {
  const exact::Deadline none(std::numeric_limits<double>::infinity());
  return std::ssize(exact::independent_columns(exact::to_dyadic(A).m, none));
}

}  // namespace lcpbench
