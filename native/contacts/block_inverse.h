#pragma once

#include <cstddef>
#include <vector>

#include "core/contact_problem.h"

namespace lcpbench {

/// G* (see inverse_inertia()) by its diagonal blocks: those of a BlockInertia, else one. Construction costs the cube of
/// each block's order, but for a given G*, which is copied; application costs its square.
class BlockInverse {
 public:
  BlockInverse() = default;
  explicit BlockInverse(const Inertia& inertia, InverseProof proof = InverseProof::kRegular);

  Index dimension() const { return static_cast<Index>(block_of_row_.size()); }
  std::size_t blocks() const { return inverses_.size(); }
  std::size_t block_of(Index row) const { return block_of_row_[static_cast<std::size_t>(row)]; }
  const Matrix& inverse(std::size_t block) const { return inverses_[block]; }
  Index offset(std::size_t block) const { return offsets_[block]; }

  /// to += G* x, both of dimension() entries. Allocates nothing.
  void add_product(const Vector& x, Vector& to) const;

 private:
  void add(Matrix inverse);

  std::vector<Matrix> inverses_;
  std::vector<Index> offsets_;
  std::vector<std::size_t> block_of_row_;
};

}  // namespace lcpbench
