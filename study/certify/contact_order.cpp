#include "study/certify/contact_order.h"

namespace lcpbench::exact {

Vector ContactOrder::original(const Vector& z) const {
  Vector result(z.size());
  for (Index i = 0; i < z.size(); ++i) result(from[static_cast<std::size_t>(i)]) = z(i);
  return result;
}

ContactOrder rotated(const ContactProblem& problem, Index shift) {
  const ContactLayout layout = contact_layout(problem);
  std::vector<Index> contacts;
  for (Index i = 0; i < layout.nc; ++i) contacts.push_back((shift + layout.nc - 1 - i) % layout.nc);

  ContactOrder order{problem, {}};
  std::vector<Index> friction;
  std::vector<Index> lambdas;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const auto contact = static_cast<std::size_t>(contacts[i]);
    order.problem.edges[i] = problem.edges[contact];
    order.problem.mu(static_cast<Index>(i)) = problem.mu(contacts[i]);
    order.from.push_back(contacts[i]);
    for (Index t = layout.friction_begin[contact]; t < layout.friction_begin[contact + 1]; ++t) {
      friction.push_back(layout.friction_offset() + t);
    }
    if (layout.lambda[contact] >= 0) lambdas.push_back(layout.lambda_offset() + layout.lambda[contact]);
  }
  const Matrix N = to_dense(problem.N);
  const Matrix D = to_dense(problem.D);
  Matrix new_N(N.rows(), N.cols());
  Matrix new_D(D.rows(), D.cols());
  for (Index i = 0; i < N.cols(); ++i) new_N.col(i) = N.col(contacts[static_cast<std::size_t>(i)]);
  for (Index t = 0; t < D.cols(); ++t) {
    new_D.col(t) = D.col(friction[static_cast<std::size_t>(t)] - layout.friction_offset());
  }
  order.problem.N = new_N;
  order.problem.D = new_D;
  order.from.insert(order.from.end(), friction.begin(), friction.end());
  order.from.insert(order.from.end(), lambdas.begin(), lambdas.end());
  return order;
}

}  // namespace lcpbench::exact
