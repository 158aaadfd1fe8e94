#include "native/contacts/dense_data.h"

#include <variant>

namespace lcpbench {

void copy_dense(const Jacobian& J, GrowingVector& to) {
  to.resize(rows(J) * cols(J));
  std::visit([&](const auto& matrix) { to.as_matrix(matrix.rows(), matrix.cols()) = matrix; }, J);
}

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
  copy_dense(J, copy);
  return copy.data();
}

}  // namespace lcpbench
