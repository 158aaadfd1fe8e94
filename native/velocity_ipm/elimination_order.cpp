#include "native/velocity_ipm/elimination_order.h"

#include <Eigen/OrderingMethods>

namespace lcpbench {

std::vector<int> elimination_order(const SparseMatrix& lower) {
  if (lower.rows() == 0) return {};
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(lower.selfadjointView<Eigen::Lower>(), order);
  return {order.indices().data(), order.indices().data() + order.size()};
}

}  // namespace lcpbench
