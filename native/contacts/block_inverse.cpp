#include "native/contacts/block_inverse.h"

#include <Eigen/Cholesky>
#include <utility>

namespace lcpbench {
namespace {

bool is_positive_diagonal(const Matrix& block) {
  for (Index j = 0; j < block.cols(); ++j) {
    for (Index i = 0; i < block.rows(); ++i) {
      if (i == j ? !(block(i, j) > 0) : block(i, j) != 0) return false;
    }
  }
  return true;
}

/// A 3 x 3 block is the mass or the rotational inertia of a body: with a size known at compile time the inverse takes a
/// tenth of the time. Masses are diagonal, and so is the inertia of spheres.
Matrix inverse_of_block(const Matrix& block, InverseProof proof) {
  if (block.rows() == 3) {
    if (is_positive_diagonal(block)) return block.diagonal().cwiseInverse().asDiagonal();
    const Eigen::LLT<Eigen::Matrix3d> factors(block);
    Matrix inverse(3, 3);
    for (Index k = 0; k < 3; ++k) inverse.col(k) = factors.solve(Eigen::Vector3d::Unit(k));
    if (factors.info() == Eigen::Success && is_far_from_singular(block, inverse, proof)) return inverse;
  }
  return inverse_inertia(DenseInertia{block}, proof);
}

}  // namespace

BlockInverse::BlockInverse(const Inertia& inertia, InverseProof proof) {
  if (const auto* given = std::get_if<BlockInertia>(&inertia)) {
    inverses_.reserve(given->blocks.size());
    offsets_.reserve(given->blocks.size());
    for (const Matrix& block : given->blocks) add(inverse_of_block(block, proof));
  } else {
    add(inverse_inertia(inertia, proof));
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
