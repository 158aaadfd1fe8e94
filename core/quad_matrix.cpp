#include "core/quad_matrix.h"

#include <limits>

namespace lcpbench {

Quad quotient(Quad value, Quad scale) {
  if (value == 0) return 0;
  return scale == 0 ? Quad{std::numeric_limits<double>::infinity()} : value / scale;
}

QuadMatrix::QuadMatrix(const Matrix& doubles)
    : QuadMatrix(static_cast<std::size_t>(doubles.rows()), static_cast<std::size_t>(doubles.cols())) {
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t j = 0; j < cols; ++j) (*this)(i, j) = doubles(static_cast<Index>(i), static_cast<Index>(j));
  }
}

QuadVector multiply(const QuadMatrix& A, const Quad* x) {
  QuadVector y(A.rows, 0);
  for (std::size_t i = 0; i < A.rows; ++i) {
    for (std::size_t j = 0; j < A.cols; ++j) y[i] += A(i, j) * x[j];
  }
  return y;
}

QuadVector multiply_transposed(const QuadMatrix& A, const Quad* x) {
  QuadVector y(A.cols, 0);
  for (std::size_t i = 0; i < A.rows; ++i) {
    for (std::size_t j = 0; j < A.cols; ++j) y[j] += A(i, j) * x[i];
  }
  return y;
}

QuadMatrix weighted_gram(const QuadMatrix& B, const QuadVector& alpha) {
  QuadMatrix gram(B.rows, B.rows);
  for (std::size_t i = 0; i < B.rows; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      Quad sum = 0;
      for (std::size_t k = 0; k < B.cols; ++k) sum += B(i, k) * B(j, k) * alpha[k];
      gram(i, j) = gram(j, i) = sum;
    }
  }
  return gram;
}

bool QuadCholesky::factor(const QuadMatrix& A) {
  const std::size_t n = A.rows;
  L_ = QuadMatrix(n, n);
  pivots_.assign(n, 0);
  QuadVector scaled(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    Quad pivot = A(i, i);
    for (std::size_t j = 0; j < i; ++j) {
      Quad sum = A(i, j);
      for (std::size_t k = 0; k < j; ++k) sum -= scaled[k] * L_(j, k);
      scaled[j] = sum;
      L_(i, j) = sum / pivots_[j];
      pivot -= sum * L_(i, j);
    }
    if (!(pivot > 0) || !is_finite(pivot)) return false;
    pivots_[i] = pivot;
  }
  return true;
}

bool QuadCholesky::factor_product(QuadMatrix C, double least) {
  const std::size_t n = C.rows;
  L_ = QuadMatrix(n, n);
  pivots_.assign(n, 0);
  const auto product = [&C](std::size_t i, std::size_t j) {
    Quad sum = 0;
    for (std::size_t k = 0; k < C.cols; ++k) sum += C(i, k) * C(j, k);
    return sum;
  };
  for (std::size_t i = 0; i < n; ++i) {
    const Quad whole = product(i, i);
    for (std::size_t j = 0; j < i; ++j) {
      L_(i, j) = product(i, j) / pivots_[j];
      for (std::size_t k = 0; k < C.cols; ++k) C(i, k) -= L_(i, j) * C(j, k);
    }
    pivots_[i] = product(i, i);
    if (!(pivots_[i] > 0) || !(pivots_[i] >= Quad{least} * least * whole) || !is_finite(pivots_[i])) return false;
  }
  return true;
}

void QuadCholesky::solve(Quad* x) const {
  const std::size_t n = size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < i; ++j) x[i] -= L_(i, j) * x[j];
  }
  for (std::size_t i = 0; i < n; ++i) x[i] /= pivots_[i];
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t j = 0; j < i; ++j) x[j] -= L_(i, j) * x[i];
  }
}

QuadMatrix QuadCholesky::root() const {
  QuadMatrix root(size(), size());
  for (std::size_t j = 0; j < size(); ++j) {
    const Quad length = sqrt(pivots_[j]);
    for (std::size_t i = j; i < size(); ++i) root(i, j) = (i == j ? Quad{1} : L_(i, j)) * length;
  }
  return root;
}

QuadMatrix QuadCholesky::inverse_root() const {
  const QuadMatrix lower = root();
  QuadMatrix inverse(size(), size());
  for (std::size_t j = 0; j < size(); ++j) {
    inverse(j, j) = 1 / lower(j, j);
    for (std::size_t i = j + 1; i < size(); ++i) {
      Quad sum = 0;
      for (std::size_t k = j; k < i; ++k) sum -= lower(i, k) * inverse(k, j);
      inverse(i, j) = sum / lower(i, i);
    }
  }
  return inverse;
}

bool proven_positive_definite(const QuadMatrix& A, std::size_t formation_terms, double least) {
  const std::size_t n = A.rows;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!(A(i, j) == A(j, i))) return false;
    }
  }
  const Quad rounding = 2.0 * static_cast<double>(n) * static_cast<double>(n + formation_terms + 4) * kQuadUnitRoundoff;
  const Quad shift = rounding + Quad{least};
  QuadMatrix shifted = A;
  for (std::size_t i = 0; i < n; ++i) shifted(i, i) -= shift * A(i, i);
  return QuadCholesky().factor(shifted);
}

}  // namespace lcpbench
