#include "native/contacts/block_inverse.h"

#include <utility>

namespace lcpbench {

BlockInverse::BlockInverse(const Inertia& inertia) {
  if (const auto* given = std::get_if<BlockInertia>(&inertia)) {
    for (const Matrix& block : given->blocks) add(inverse_inertia(DenseInertia{block}));
  } else {
    add(inverse_inertia(inertia));
  }
}

void BlockInverse::add(Matrix inverse) {
  offsets_.push_back(dimension());
  block_of_row_.insert(block_of_row_.end(), static_cast<std::size_t>(inverse.rows()), inverses_.size());
  inverses_.push_back(std::move(inverse));
}

void BlockInverse::add_product(const Vector& x, Vector& to) const {
  for (std::size_t block = 0; block < blocks(); ++block) {
    const Matrix& part = inverses_[block];
    to.segment(offsets_[block], part.rows()).noalias() += part * x.segment(offsets_[block], part.rows());
  }
}

}  // namespace lcpbench
