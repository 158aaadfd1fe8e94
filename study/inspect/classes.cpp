#include "study/inspect/classes.h"

#include <algorithm>

#include "core/quad_matrix.h"

namespace lcpbench {
namespace {

/// Pivots below this much of their row's largest entry may be rounding: a dozen eliminations lose no more.
constexpr double kDoubtful = 0x1p-80;

Quad largest_entry(const QuadMatrix& A) {
  Quad largest = 0;
  for (const Quad entry : A.entries) largest = std::max(largest, abs(entry));
  return largest;
}

QuadMatrix without_first(const QuadMatrix& A) {
  QuadMatrix rest(A.rows - 1, A.cols - 1);
  for (std::size_t i = 1; i < A.rows; ++i) {
    for (std::size_t j = 1; j < A.cols; ++j) rest(i - 1, j - 1) = A(i, j);
  }
  return rest;
}

QuadMatrix schur_complement(const QuadMatrix& A) {
  QuadMatrix rest = without_first(A);
  for (std::size_t i = 1; i < A.rows; ++i) {
    for (std::size_t j = 1; j < A.cols; ++j) rest(i - 1, j - 1) -= A(i, 0) * A(0, j) / A(0, 0);
  }
  return rest;
}

Tri all_minors_positive(const QuadMatrix& A, Quad scale) {
  if (A.rows == 0) return Tri::kYes;
  const Quad pivot = A(0, 0);
  if (pivot < -kDoubtful * scale) return Tri::kNo;
  if (!(pivot > kDoubtful * scale)) return Tri::kUnknown;
  const Tri rest = all_minors_positive(without_first(A), scale);
  if (rest != Tri::kYes) return rest;
  return all_minors_positive(schur_complement(A), scale);
}

}  // namespace

bool is_z_matrix(const Matrix& M) {
  for (Index j = 0; j < M.cols(); ++j) {
    for (Index i = 0; i < M.rows(); ++i) {
      if (i != j && !(M(i, j) <= 0)) return false;
    }
  }
  return true;
}

Tri is_p_matrix(const Matrix& M) {
  for (Index i = 0; i < M.rows(); ++i) {
    if (!(M(i, i) > 0)) return Tri::kNo;
  }
  if (M.rows() > kLargestMinors) return Tri::kUnknown;
  const QuadMatrix A(M);
  return all_minors_positive(A, largest_entry(A));
}

std::optional<std::pair<Index, Index>> copositivity_counterexample(const Matrix& M) {
  for (Index i = 0; i < M.rows(); ++i) {
    if (M(i, i) < 0) return std::pair(i, i);
  }
  for (Index j = 0; j < M.cols(); ++j) {
    for (Index i = j + 1; i < M.rows(); ++i) {
      const Quad off = (Quad{M(i, j)} + Quad{M(j, i)}) / 2;
      if (off < 0 && off * off > Quad{M(i, i)} * Quad{M(j, j)}) return std::pair(i, j);
    }
  }
  return std::nullopt;
}

const char* to_string(Tri value) {
  switch (value) {
    case Tri::kNo: return "no";
    case Tri::kYes: return "yes";
    case Tri::kUnknown: break;
  }
  return "unknown";
}

}  // namespace lcpbench
