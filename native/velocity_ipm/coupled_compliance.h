#pragma once

#include <cstddef>
#include <vector>

#include "core/contact_problem.h"

namespace lcpbench {

/// A compliance R that couples the impulses of columns that stand next to each other, as those of one contact's cone
/// are, and what an interior-point method needs of it. Only add_block() allocates.
class CoupledCompliance {
 public:
  struct Block {
    Index first = 0;  ///< of its columns
    Index size = 0;
    std::size_t value = 0;  ///< where its matrices begin, by columns
  };

  bool empty() const { return blocks_.empty(); }
  const std::vector<Block>& blocks() const { return blocks_; }
  /// Of the next columns; in the end all columns must be in a block. @param R symmetric positive semidefinite
  void add_block(const Matrix& R);

  Vector diagonal() const;
  /// s += R f
  void add_product(const Vector& f, Vector& s) const;
  /// K with K K' = (diag(weights)^-1 + R)^-1, weights >= 0. False where that is not a number.
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
