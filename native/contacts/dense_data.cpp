#include "native/contacts/dense_data.h"

#include <variant>

namespace lcpbench {

void copy_dense(const BlockInertia& inertia, Index dimension, GrowingVector& to) {
  to.resize(dimension * dimension);
  Eigen::Map<Matrix> G = to.as_matrix(dimension, dimension);
  G.setZero();
  Index at = 0;
  for (const Matrix& block : inertia.blocks) {
    G.block(at, at, block.rows(), block.rows()) = block;
    at += block.rows();
  }
}

const double* dense_data(const Jacobian& J, GrowingVector& copy) {
  if (const auto* dense = std::get_if<Matrix>(&J)) return dense->data();
  copy.resize(rows(J) * cols(J));
  copy.as_matrix(rows(J), cols(J)) = std::get<SparseMatrix>(J);
  return copy.data();
}

}  // namespace lcpbench
