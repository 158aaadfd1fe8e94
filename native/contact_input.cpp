#include "native/contact_input.h"

#include <variant>

namespace lcpbench {

void ContactInput::load(const ContactProblem& contact) {
  v = contact.v;
  mu = contact.mu;
  friction_begin.assign(1, 0);
  for (const int edges : contact.edges) friction_begin.push_back(friction_begin.back() + edges);
  input = {};
  input.ngc = contact.ngc();
  input.nc = contact.nc();
  input.v = v.data();
  input.N = dense_data(contact.N, N);
  input.D = dense_data(contact.D, D);
  input.friction_begin = friction_begin.data();
  input.mu = mu.data();
  load_inertia(contact.inertia);
}

const double* ContactInput::dense_data(const Jacobian& jacobian, Matrix& copy) {
  if (const auto* dense = std::get_if<Matrix>(&jacobian)) return dense->data();
  copy = to_dense(jacobian);
  return copy.data();
}

void ContactInput::load_inertia(const Inertia& inertia) {
  contact_lemke::InertiaInput& to = input.inertia;
  offsets.assign(1, 0);
  blocks.clear();
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) {
    add_block(dense->G);
  } else if (const auto* separate = std::get_if<BlockInertia>(&inertia)) {
    for (const Matrix& block : separate->blocks) add_block(block);
  } else if (const auto* factored = std::get_if<FactoredInertia>(&inertia)) {
    to.factors = factored->X.cols();
    to.X = factored->X.data();
    to.alpha = factored->alpha.data();
  } else {
    to.Ginv = std::get<InverseInertia>(inertia).Ginv.data();
  }
  to.blocks = static_cast<std::ptrdiff_t>(blocks.size());
  to.offsets = offsets.data();
  to.G = blocks.data();
}

void ContactInput::add_block(const Matrix& G) {
  blocks.push_back(G.data());
  offsets.push_back(offsets.back() + G.rows());
}

}  // namespace lcpbench
