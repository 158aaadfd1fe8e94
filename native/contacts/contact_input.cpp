#include "native/contacts/contact_input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <variant>

#include "core/compliance.h"
#include "native/contacts/dense_data.h"

namespace lcpbench {
namespace {

/// x times a power of two. NaN, with which no answer passes a test, where bits of x are lost.
double times(double x, double power) {
  const double product = x * power;
  return product / power == x ? product : std::numeric_limits<double>::quiet_NaN();
}

/// Copies J by columns, its rows multiplied by `units` if there are any, with a last row of zeros if has_offset.
const double* copy_jacobian(const Jacobian& J, const GrowingVector& units, bool has_offset, GrowingVector& copy) {
  const Index ngc = rows(J);
  const Index all = ngc + (has_offset ? 1 : 0);
  copy.resize(all * cols(J));
  Eigen::Map<Matrix> to = copy.as_matrix(all, cols(J));
  std::visit([&](const auto& matrix) { to.topRows(ngc) = matrix; }, J);
  for (Index i = 0; i < units.size(); ++i) {
    to.row(i) = to.row(i).unaryExpr([unit = units(i)](double x) { return times(x, unit); });
  }
  if (has_offset) to.row(ngc).setZero();
  return copy.data();
}

/// The largest power of two that is no more than the largest |b_i|, or 1 if b is zero or subnormal.
double speed_of_offset(const Vector& b) {
  const double largest = b.cwiseAbs().maxCoeff();
  return std::isnormal(largest) ? std::ldexp(1.0, std::ilogb(largest)) : 1.0;
}

/// Calls visit(i, G_ii) for G given whole or by blocks; else never.
template <class Visit>
void for_each_diagonal_entry(const Inertia& inertia, Visit&& visit) {
  if (!std::holds_alternative<DenseInertia>(inertia) && !std::holds_alternative<BlockInertia>(inertia)) return;
  for_each_matrix(inertia, [&](const Matrix& G, Index first) {
    for (Index i = 0; i < G.rows(); ++i) visit(first + i, G(i, i));
  });
}

/// Whether the diagonal of G, where it is given whole or by blocks, is positive and spans more than 2^50: its entries
/// are then taken for entries in different units.
bool mixes_units(const Inertia& inertia) {
  constexpr double kSameUnit = 0x1p50;
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  for_each_diagonal_entry(inertia, [&](Index, double entry) {
    least = std::min(least, entry);
    most = std::max(most, entry);
  });
  return least > 0 && most > kSameUnit * least;
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
  find_islands(contact);
  choose_units(contact.inertia);
  set_velocity(contact.v);
  load_jacobians(contact);
  load_inertia(contact.inertia);
}

void ContactInput::choose_units(const Inertia& inertia) {
  units.resize(0);
  if (!mixes_units(inertia)) return;
  units.resize(dimension(inertia));
  for_each_diagonal_entry(inertia, [&](Index i, double entry) {
    units.view()(i) = std::ldexp(1.0, -static_cast<int>(std::floor(std::ilogb(entry) / 2.0)));
  });
}

void ContactInput::set_velocity(const Vector& velocity) {
  v.resize(input.ngc);
  v.view().head(velocity.size()) = velocity;
  for (Index i = 0; i < units.size(); ++i) v.view()(i) = times(velocity(i), 1 / units(i));
  if (input.has_offset) v.view()(velocity.size()) = offset_speed;
  input.v = v.data();
}

void ContactInput::load_jacobians(const ContactProblem& contact) {
  if (units.size() == 0 && !input.has_offset) {
    input.N = dense_data(contact.N, N);
    input.D = dense_data(contact.D, D);
    return;
  }
  input.N = copy_jacobian(contact.N, units, input.has_offset, N);
  input.D = copy_jacobian(contact.D, units, input.has_offset, D);
  if (!input.has_offset) return;
  for (Index c = 0; c < input.nc; ++c) {  // of a gap that is next to nothing no bit is missed
    const double b = contact.b(c);
    N.data()[(c + 1) * input.ngc - 1] = b >= 0 ? b / offset_speed : times(b, 1 / offset_speed);
  }
}

void ContactInput::load_layout(const ContactProblem& contact) {
  mu = contact.mu;
  friction_begin.assign(1, 0);
  for (const int edges : contact.edges) friction_begin.push_back(friction_begin.back() + edges);
  input = {};
  input.ngc = coordinates(contact);
  input.has_offset = contact.has_offset();
  if (input.has_offset) offset_speed = speed_of_offset(contact.b);
  input.nc = contact.nc();
  input.friction_begin = friction_begin.data();
  input.mu = mu.data();
  if (contact.is_soft()) load_softness(contact);
}

void ContactInput::load_softness(const ContactProblem& contact) {
  const auto fill = [](const Vector& values, Index size, GrowingVector& to) {
    to.resize(size);
    to.view().setZero();
    to.view().head(values.size()) = values;
    return to.data();
  };
  input.compliance_n = fill(contact.compliance_n, input.nc, compliance_n);
  input.compliance_t = fill(contact.compliance_t, input.nc, compliance_t);
  input.offset_t = fill(contact.offset_t, 2 * input.nc, offset_t);
  tangents.resize(2 * friction_begin.back());
  Index column = 0;
  for (const int edges : contact.edges) {
    for (Index k = 0; k < edges; ++k, column += 2) {
      const std::array<double, 2> direction = edge_direction(k, edges);
      std::copy(direction.begin(), direction.end(), tangents.data() + column);
    }
  }
  input.tangents = tangents.data();
}

void ContactInput::find_islands(const ContactProblem& contact) {
  // A contact without nonzero entries is not in the island that has all coordinates. With an offset or a compliance it
  // still has a w, which must not be measured by the scale of that island.
  if ((is_one_island || (couples_all(contact.inertia) && !contact.is_soft())) && !input.has_offset) return;
  islands.find(contact);
  if (input.has_offset) islands.of_coordinate.push_back(-1);
  input.islands = islands.count;
  input.island_of_contact = islands.of_contact.data();
  input.island_of_coordinate = islands.of_coordinate.data();
}

void ContactInput::load_inertia(const Inertia& inertia) {
  contact_lemke::InertiaInput& to = input.inertia;
  offsets.assign(1, 0);
  blocks.clear();
  if (const auto* factored = std::get_if<FactoredInertia>(&inertia)) {
    to.factors = factored->X.cols();
    to.X = factored->X.data();
    to.alpha = factored->alpha.data();
  } else if (const auto* inverse = std::get_if<InverseInertia>(&inertia)) {
    to.Ginv = inverse->Ginv.data();
  } else {
    load_blocks(inertia);
  }
  to.blocks = static_cast<std::ptrdiff_t>(blocks.size());
  to.offsets = offsets.data();
  to.G = blocks.data();
}

/// G, or S G S in the units S, block by block.
void ContactInput::load_blocks(const Inertia& inertia) {
  const bool in_units = units.size() > 0;
  Index entries = 0;
  for_each_matrix(inertia, [&](const Matrix& block, Index) { entries += in_units ? block.size() : 0; });
  G.resize(entries);
  double* next = G.data();
  for_each_matrix(inertia, [&](const Matrix& block, Index first) {
    blocks.push_back(in_units ? next : block.data());
    offsets.push_back(offsets.back() + block.rows());
    if (!in_units) return;
    const auto own = units.view().segment(first, block.rows()).asDiagonal();
    Eigen::Map<Matrix>(next, block.rows(), block.rows()) = own * block * own;
    next += block.size();
  });
}

}  // namespace lcpbench
