#pragma once

// Whitening by the factors of a positive definite inertia.

#include "native/active_set/whitening.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

inline bool Whitening::factor_dense(const double* G) {
  if (!eliminate(G) || underflows_) return false;
  triangular_ = true;
  rank_ = ngc_;
  scale_rows();
  return true;
}

inline bool Whitening::eliminate(const double* G) {
  for (Count i = 0; i < ngc_; ++i) {
    double* row = work_row(i);
    widen(G + i * ngc_, ngc_, row);
    copy(row + velocity_lanes_, normals_.data() + i * contact_lanes_, contact_lanes_);
    root_diagonal_[i] = row[i];  // G_ii, until scale_rows
  }
  const double least = static_cast<double>(ngc_) * kEpsilon;
  double pivot = ngc_ > 0 ? work_row(0)[0] : 0.0;
  Count end = 0;
  underflows_ = false;
  for (Count k = 0; k < ngc_; ++k) {
    const double* pivot_row = work_row(k);
    end = profile_end(pivot_row, end > k ? end : k + 1);
    if (!(pivot > least * root_diagonal_[k])) return false;
    if (pivot < kLeastPivot) underflows_ = true;
    pivots_[k] = pivot;
    const double inverse = 1 / pivot;
    // The next pivot is computed apart from its row, so that its reciprocal need not wait for that to be written.
    if (k + 1 < ngc_) pivot = work_row(k + 1)[k + 1] + -pivot_row[k + 1] * inverse * pivot_row[k + 1];
    const Count first = k / L::kWidth * L::kWidth;
    eliminate_rows_below(rows_.data(), stride_, k, end, first, inverse);
  }
  return true;
}

inline void Whitening::scale_rows() {
  for (Count i = ngc_; i < velocity_lanes_; ++i) {
    root_diagonal_[i] = 0;
    pivots_[i] = 1;
  }
  // Loops of their own, which compilers turn into roots of whole registers.
  for (Count i = 0; i < velocity_lanes_; ++i) root_diagonal_[i] = square_root(root_diagonal_[i]);
  for (Count i = 0; i < velocity_lanes_; ++i) inverse_diagonal_[i] = 1 / square_root(pivots_[i]);
  auto growth = L::broadcast(1);
  for (Count i = 0; i < velocity_lanes_; i += L::kWidth) {
    const auto root = L::load(root_diagonal_.data() + i);
    growth = L::max(root * L::load(inverse_diagonal_.data() + i), growth);
    L::store(inverse_bound_.data() + i, root);
  }
  set_noise(L::max(growth));
  double squared_bound = 0;
  for (Count i = 0; i < ngc_; ++i) {
    double* const row = work_row(i);
    const Count first = i / L::kWidth * L::kWidth;
    const double bound = inverse_bound_[i] * inverse_diagonal_[i];
    squared_bound += bound * bound;
    const auto factor = L::broadcast(inverse_diagonal_[i]);
    const auto weight = L::broadcast(bound);
    for (Count j = first; j < velocity_lanes_; j += L::kWidth) {
      auto entries = factor * L::load(row + j);
      if (j == first) {  // elimination left something before the diagonal
        entries = lane_numbers<double>() >= static_cast<double>(i - first) ? entries : L::broadcast(0);
      }
      L::store(row + j, entries);
      double* const bounds = inverse_bound_.data() + j;
      L::store(bounds, L::load(bounds) + weight * L::max(entries, -entries));
    }
    scale(row + velocity_lanes_, inverse_diagonal_[i], contact_lanes_);
  }
  bound_condition(squared_bound);
  make_columns();
}

inline void Whitening::make_columns() {
  for (Count i = ngc_; i < velocity_lanes_; ++i) set_zero(work_row(i), velocity_lanes_);
  for (Count i = 0; i < velocity_lanes_; i += L::kWidth) {
    double* const columns = columns_.data() + i * velocity_lanes_;
    for (Count j = 0; j <= i; j += L::kWidth) {
      transpose_block(work_row(j) + i, stride_, columns + j, velocity_lanes_);
    }
    const Count behind = i + L::kWidth;
    for (Count k = 0; k < L::kWidth; ++k) set_zero(columns + k * velocity_lanes_ + behind, velocity_lanes_ - behind);
  }
}

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
