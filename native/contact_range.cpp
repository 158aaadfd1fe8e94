// The range of the inertia, for ContactSolvability.
#include <algorithm>
#include <cmath>
#include <utility>

#include "native/contact_solvability.h"
#include "native/scaled_numbers.h"

namespace lcpbench {
namespace {

/// Entries of a scaled matrix above this are more than rounding.
constexpr Quad kLeastPivot = 0x1p-92;

}  // namespace

/// A basis of the range of X by elimination of columns with complete pivoting: ones in the rows of the pivots.
void ContactSolvability::find_range() {
  if (has_range_) return;
  has_range_ = true;
  const Index ngc = X_->rows();
  const Index count = X_->cols();
  range_.resize(static_cast<std::size_t>(ngc * count));
  unit_.assign(static_cast<std::size_t>(ngc), 0);
  rank_ = count;
  const auto at = [&](Index i, Index k) -> Quad& { return range_[static_cast<std::size_t>(i * count + k)]; };
  for (Index k = 0; k < count; ++k) {
    const double largest = ngc > 0 ? X_->col(k).cwiseAbs().maxCoeff() : 0.0;
    const int exponent = largest > 0 ? -exponent_of(largest) : 0;
    for (Index i = 0; i < ngc; ++i) at(i, k) = scaled(static_cast<Quad>((*X_)(i, k)), exponent);
  }
  for (Index i = 0; i < ngc; ++i) {
    Quad largest = 0;
    for (Index k = 0; k < count; ++k) largest = std::max(largest, magnitude(at(i, k)));
    if (!(largest > 0)) continue;
    unit_[static_cast<std::size_t>(i)] = exponent_of(to_double(largest));
    for (Index k = 0; k < count; ++k) at(i, k) = scaled(at(i, k), -unit_[static_cast<std::size_t>(i)]);
  }
  least_range_pivot_ = 1;
  pivot_rows_.clear();
  rank_ = 0;
  for (; rank_ < std::min(ngc, count); ++rank_) {
    Index row = 0;
    Index column = rank_;
    for (Index i = 0; i < ngc; ++i) {
      for (Index k = rank_; k < count; ++k) {
        if (magnitude(at(i, k)) > magnitude(at(row, column))) row = i, column = k;
      }
    }
    const Quad pivot = at(row, column);
    if (!(magnitude(pivot) > kLeastPivot)) break;
    least_range_pivot_ = std::min(least_range_pivot_, magnitude(pivot));
    pivot_rows_.push_back(row);
    for (Index i = 0; i < ngc; ++i) std::swap(at(i, rank_), at(i, column));
    for (Index i = 0; i < ngc; ++i) at(i, rank_) /= pivot;
    for (Index k = 0; k < count; ++k) {
      const Quad factor = at(row, k);
      if (k == rank_ || factor == 0) continue;
      for (Index i = 0; i < ngc; ++i) at(i, k) -= factor * at(i, rank_);
      at(row, k) = 0;
    }
  }
  for (Index i = 0; i < ngc; ++i) {
    for (Index k = 0; k < rank_; ++k) {
      range_[static_cast<std::size_t>(i * rank_ + k)] = scaled(at(i, k), unit_[static_cast<std::size_t>(i)]);
    }
  }
}

void ContactSolvability::find_unreached_velocity() {
  const Index ngc = X_->rows();
  unreached_v_.assign(v_, v_ + ngc);
  for (Index k = 0; k < rank_; ++k) {
    const Index row = pivot_rows_[static_cast<std::size_t>(k)];
    const Quad share = static_cast<Quad>(v_[row]) / reach(row, k, Quad());
    for (Index i = 0; i < ngc && share != 0; ++i)
      unreached_v_[static_cast<std::size_t>(i)] -= share * reach(i, k, Quad());
  }
  for (const Index row : pivot_rows_) unreached_v_[static_cast<std::size_t>(row)] = 0;
}

}  // namespace lcpbench
