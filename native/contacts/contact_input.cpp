#include "native/contacts/contact_input.h"

#include <variant>

#include "native/contacts/contact_units.h"
#include "native/contacts/dense_data.h"

namespace lcpbench {
namespace {

const double* data_in_units(const Jacobian& J, const GrowingVector& units, GrowingVector& copy) {
  copy_dense(J, copy);
  copy.as_matrix(rows(J), cols(J)).array().colwise() *= units.view().array();
  return copy.data();
}

}  // namespace

void ContactInput::reserve(Index ngc, Index nc, Index directions) {
  v.reserve(ngc);
  mu.reserve(nc);
  units.reserve(ngc);
  N.reserve(ngc * nc);
  D.reserve(ngc * directions);
  G.reserve(ngc * ngc);
  friction_begin.reserve(static_cast<std::size_t>(nc) + 1);
  blocks.reserve(static_cast<std::size_t>(ngc) + 1);
  offsets.reserve(static_cast<std::size_t>(ngc) + 2);
  islands.reserve(ngc, nc);
}

void ContactInput::load(const ContactProblem& contact) {
  load_layout(contact);
  units.resize(0);
  v = contact.v;
  input.v = v.data();
  input.N = dense_data(contact.N, N);
  input.D = dense_data(contact.D, D);
  load_inertia(contact.inertia);
}

void ContactInput::load_in_units(const ContactProblem& contact) {
  if (!mixes_units(contact.inertia)) return load(contact);
  load_layout(contact);
  units.resize(contact.ngc());
  write_coordinate_units(contact.inertia, units.view());
  set_velocity(contact.v);
  input.v = v.data();
  input.N = data_in_units(contact.N, units, N);
  input.D = data_in_units(contact.D, units, D);
  load_inertia_in_units(contact.inertia);
}

void ContactInput::set_velocity(const Vector& velocity) {
  v = velocity;
  if (units.size() > 0) v.array() /= units.view().array();
}

void ContactInput::load_layout(const ContactProblem& contact) {
  mu = contact.mu;
  friction_begin.assign(1, 0);
  for (const int edges : contact.edges) friction_begin.push_back(friction_begin.back() + edges);
  input = {};
  input.ngc = contact.ngc();
  input.nc = contact.nc();
  input.friction_begin = friction_begin.data();
  input.mu = mu.data();
  if (couples_all(contact.inertia)) return;
  islands.find(contact);
  input.islands = islands.count;
  input.island_of_contact = islands.of_contact.data();
  input.island_of_coordinate = islands.of_coordinate.data();
}

void ContactInput::load_inertia(const Inertia& inertia) {
  contact_lemke::InertiaInput& to = input.inertia;
  offsets.assign(1, 0);
  blocks.clear();
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) {
    add_block(dense->G.data(), dense->G.rows());
  } else if (const auto* separate = std::get_if<BlockInertia>(&inertia)) {
    for (const Matrix& block : separate->blocks) add_block(block.data(), block.rows());
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

/// S G S as one block. @pre mixes_units(inertia)
void ContactInput::load_inertia_in_units(const Inertia& inertia) {
  G.resize(input.ngc * input.ngc);
  Eigen::Map<Matrix> all = G.as_matrix(input.ngc, input.ngc);
  if (const auto* bodies = std::get_if<BlockInertia>(&inertia)) {
    copy_dense(*bodies, input.ngc, G);
  } else {
    all = std::get<DenseInertia>(inertia).G;
  }
  all.array().colwise() *= units.view().array();
  all.array().rowwise() *= units.view().transpose().array();
  offsets.assign(1, 0);
  blocks.clear();
  add_block(G.data(), input.ngc);
  input.inertia.blocks = 1;
  input.inertia.offsets = offsets.data();
  input.inertia.G = blocks.data();
}

void ContactInput::add_block(const double* entries, Index size) {
  blocks.push_back(entries);
  offsets.push_back(offsets.back() + size);
}

}  // namespace lcpbench
