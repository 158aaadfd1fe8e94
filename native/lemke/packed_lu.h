#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>

#include "native/lemke/pack.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Eigen's LU with partial pivoting, by its kernels and bit for bit, without the heap: the packed blocks of products
/// that Eigen's limit bars from the stack are written where load() took memory. Follows partial_lu_impl::blocked_lu of
/// Eigen 3.4, which offers no way to pass that memory.
template <class Scalar>
class PackedLu : public Eigen::PartialPivLU<Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>> {
 public:
  using Dense = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  void load(Count n) {
    if (this->rows() != n) static_cast<Base&>(*this) = Base(n);
    const Count block = block_size(n, kMaxBlock);
    large_ = !fits_stack(n * block);
    if (!large_) return;
    lhs_.resize(n * block);
    rhs_.resize(n * block);
  }

  /// @param matrix n x n
  void factor(const Dense& matrix) {
    if (!large_) {
      this->compute(matrix);
      return;
    }
    this->m_lu = matrix;
    factor_panel(matrix.rows(), matrix.cols(), this->m_lu.data(), this->m_rowsTranspositions.indices().data(),
                 kMaxBlock);
    this->m_p = this->m_rowsTranspositions;
    this->m_isInitialized = true;
  }

 private:
  using Base = Eigen::PartialPivLU<Dense>;
  using Swap = typename Base::TranspositionType::StorageIndex;
  using View = Eigen::Ref<Dense>;
  using Unblocked = Eigen::internal::partial_lu_impl<Scalar, Eigen::ColMajor, Swap, Eigen::Dynamic>;

  static constexpr Count kMaxBlock = 256;
  static constexpr Count kMaxPanelBlock = 16;
  static constexpr Count kUnblocked = 16;

  /// Block sizes of a product, and where its blocks go.
  template <int kDepthFactor>
  struct Blocking : Eigen::internal::level3_blocking<Scalar, Scalar> {
    Blocking(PackedLu& lu, Count rows, Count cols, Count depth, bool splits_cols) {
      this->m_mc = rows;
      this->m_nc = cols;
      this->m_kc = depth;
      Count all_cols = cols;
      Eigen::internal::computeProductBlockingSizes<Scalar, Scalar, kDepthFactor>(
          this->m_kc, this->m_mc, splits_cols ? this->m_nc : all_cols, Count{1});
      this->m_blockA = lu.lhs_.data();
      this->m_blockB = lu.rhs_.data();
    }
  };

  static Count block_size(Count size, Count largest) {
    return std::min(std::max<Count>(size / 8 / 16 * 16, 8), largest);
  }
  static bool fits_stack(Count entries) {
    return static_cast<std::size_t>(entries) * sizeof(Scalar) <= EIGEN_STACK_ALLOCATION_LIMIT;
  }

  void factor_panel(Count rows, Count cols, Scalar* data, Swap* swaps, Count largest_block) {
    const Count stride = this->m_lu.outerStride();
    View lu = Dense::Map(data, rows, cols, Eigen::OuterStride<>(stride));
    Swap swapped = 0;
    if (cols <= kUnblocked) {
      Unblocked::unblocked_lu(lu, swaps, swapped);
      return;
    }
    const Count block = block_size(cols, largest_block);
    for (Count k = 0; k < cols; k += block) {
      const Count size = std::min(cols - k, block);
      const Count below = rows - k - size;
      const Count right = cols - k - size;
      factor_panel(below + size, size, &lu.coeffRef(k, k), swaps + k, kMaxPanelBlock);
      for (Count i = k; i < k + size; ++i) {
        swaps[i] += static_cast<Swap>(k);
        lu.row(i).head(k).swap(lu.row(swaps[i]).head(k));
      }
      if (below == 0) continue;
      for (Count i = k; i < k + size; ++i) lu.row(i).tail(right).swap(lu.row(swaps[i]).tail(right));
      eliminate(lu.block(k, k, size, size), lu.block(k, k + size, size, right));
      subtract(lu.block(k + size, k, below, size), lu.block(k, k + size, size, right),
               lu.block(k + size, k + size, below, right));
    }
  }

  /// right := (unit lower triangle of diagonal)^-1 right.
  void eliminate(View diagonal, View right) {
    const Count size = diagonal.rows();
    if (fits_stack(size * std::max(size, right.cols()))) {
      diagonal.template triangularView<Eigen::UnitLower>().solveInPlace(right);
      return;
    }
    Blocking<4> blocking(*this, size, right.cols(), size, false);
    Eigen::internal::triangular_solve_matrix<Scalar, Count, Eigen::OnTheLeft, Eigen::UnitLower, false, Eigen::ColMajor,
                                             Eigen::ColMajor, 1>::run(size, right.cols(), diagonal.data(),
                                                                      diagonal.outerStride(), right.data(), 1,
                                                                      right.outerStride(), blocking);
  }

  /// rest -= below * right.
  void subtract(View below, View right, View rest) {
    const Count depth = below.cols();
    // Eigen takes products with one column for products with a vector, which need no room.
    if (rest.cols() < 2 || fits_stack(depth * std::max(rest.rows(), rest.cols()))) {
      rest.noalias() -= below * right;
      return;
    }
    Blocking<1> blocking(*this, rest.rows(), rest.cols(), depth, true);
    Eigen::internal::general_matrix_matrix_product<Count, Scalar, Eigen::ColMajor, false, Scalar, Eigen::ColMajor,
                                                   false, Eigen::ColMajor, 1>::run(rest.rows(), rest.cols(), depth,
                                                                                   below.data(), below.outerStride(),
                                                                                   right.data(), right.outerStride(),
                                                                                   rest.data(), 1, rest.outerStride(),
                                                                                   Scalar(-1), blocking);
  }

  bool large_ = false;
  Buffer<Scalar> lhs_, rhs_;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
