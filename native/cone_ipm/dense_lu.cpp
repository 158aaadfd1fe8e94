#include "native/cone_ipm/dense_lu.h"

#include <algorithm>
#include <cmath>

namespace lcpbench {
namespace {

/// Columns of a panel. The columns after it are updated by the whole panel at once, so that each of their entries is
/// read and written once for eight columns. eliminate() has a term for each column.
constexpr Index kPanel = 8;

}  // namespace

void DenseLu::resize(Index order) {
  matrix_.resize(order, order);
  swapped_with_.resize(static_cast<std::size_t>(order));
}

/// Factors `width` columns from `first` on; exchanges whole rows of the matrix.
bool DenseLu::factor_panel(Index first, Index width) {
  const Index n = matrix_.rows();
  for (Index k = first; k < first + width; ++k) {
    Index pivot = 0;
    const double largest = matrix_.col(k).tail(n - k).cwiseAbs().maxCoeff(&pivot);
    pivot += k;
    if (!(largest > 0) || !std::isfinite(largest)) return false;
    swapped_with_[static_cast<std::size_t>(k)] = pivot;
    if (pivot != k) matrix_.row(k).swap(matrix_.row(pivot));
    const double inverse = 1 / matrix_(k, k);
    if (!std::isfinite(inverse)) return false;
    double* column = matrix_.col(k).data();
    for (Index i = k + 1; i < n; ++i) column[i] *= inverse;
    for (Index j = k + 1; j < first + width; ++j) {
      const double factor = matrix_(k, j);
      double* other = matrix_.col(j).data();
      for (Index i = k + 1; i < n; ++i) other[i] -= factor * column[i];
    }
  }
  return true;
}

/// Updates the columns after a panel of kPanel columns that begins at `first`.
void DenseLu::eliminate(Index first) {
  const Index n = matrix_.rows();
  const Index end = first + kPanel;
  for (Index j = end; j < n; ++j) {
    double* column = matrix_.col(j).data();
    for (Index k = first; k < end; ++k) {
      for (Index i = k + 1; i < end; ++i) column[i] -= matrix_(i, k) * column[k];
    }
    const double* L = matrix_.col(first).data();
    const double* u = column + first;
    for (Index i = end; i < n; ++i) {
      column[i] -= L[i] * u[0] + L[n + i] * u[1] + L[2 * n + i] * u[2] + L[3 * n + i] * u[3] + L[4 * n + i] * u[4] +
                   L[5 * n + i] * u[5] + L[6 * n + i] * u[6] + L[7 * n + i] * u[7];
    }
  }
}

bool DenseLu::factor() {
  const Index n = matrix_.rows();
  for (Index first = 0; first < n; first += kPanel) {
    const Index width = std::min(kPanel, n - first);
    if (!factor_panel(first, width)) return false;
    if (width == kPanel) eliminate(first);  // a narrower panel is the last
  }
  return true;
}

void DenseLu::solve(Vector& x) const {
  const Index n = matrix_.rows();
  for (Index k = 0; k < n; ++k) std::swap(x(k), x(swapped_with_[static_cast<std::size_t>(k)]));
  for (Index k = 0; k < n; ++k) x.tail(n - k - 1) -= x(k) * matrix_.col(k).tail(n - k - 1);
  for (Index k = n - 1; k >= 0; --k) {
    x(k) /= matrix_(k, k);
    x.head(k) -= x(k) * matrix_.col(k).head(k);
  }
}

}  // namespace lcpbench
