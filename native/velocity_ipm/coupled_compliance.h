#pragma once

#include <cstddef>
#include <vector>

#include "core/contact_problem.h"

namespace lcpbench {

/// A block-diagonal compliance R: each block couples the impulses of adjacent columns, those of one contact. It has the
/// products that an interior-point method needs. Only add_block() and diagonal() allocate.
class CoupledCompliance {
 public:
  struct Block {
    Index first = 0;  ///< its first column
    Index size = 0;
    std::size_t value = 0;  ///< offset of its matrices in R_ and roots_, stored by columns
  };

  bool empty() const { return blocks_.empty(); }
  const std::vector<Block>& blocks() const { return blocks_; }
  /// The block of the next columns. In the end every column must be in one. @param R symmetric positive semidefinite
  void add_block(const Matrix& R);

  Vector diagonal() const;
  /// s += R f
  void add_product(const Vector& f, Vector& s) const;
  /// Finds K with K K' = (diag(weights)^-1 + R)^-1, O(size^3) for each block. False: K is not finite, and not to be
  /// used. @param weights >= 0, finite
  bool factor(const Vector& weights);
  /// K of a block, upper triangular, zeros included.
  const double* root(const Block& block) const { return roots_.data() + block.value; }
  /// x := K K' x
  void apply_weights(Vector& x) const;

 private:
  std::vector<Block> blocks_;
  std::vector<double> R_, roots_;
};

}  // namespace lcpbench
