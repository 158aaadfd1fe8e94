#include "native/contact_units.h"

#include <cmath>
#include <variant>

namespace lcpbench {
namespace {

/// Diagonal entries of G that differ by more than this are taken for entries in different units.
constexpr double kSameUnit = 0x1p50;

/// The diagonal of G given whole or by blocks; else empty.
Vector diagonal_of(const Inertia& inertia) {
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) return dense->G.diagonal();
  Vector diagonal;
  if (const auto* bodies = std::get_if<BlockInertia>(&inertia)) {
    diagonal.resize(dimension(inertia));
    Index at = 0;
    for (const Matrix& block : bodies->blocks) {
      diagonal.segment(at, block.rows()) = block.diagonal();
      at += block.rows();
    }
  }
  return diagonal;
}

Jacobian in_units(const Jacobian& J, const Vector& units) {
  if (const auto* dense = std::get_if<Matrix>(&J)) return Matrix(units.asDiagonal() * *dense);
  return SparseMatrix(units.asDiagonal() * std::get<SparseMatrix>(J));
}

}  // namespace

Vector coordinate_units(const Inertia& inertia) {
  Vector units = diagonal_of(inertia);
  if (units.size() == 0 || !(units.minCoeff() > 0) || !(units.maxCoeff() > kSameUnit * units.minCoeff())) return {};
  for (double& unit : units) unit = std::ldexp(1.0, -static_cast<int>(std::floor(std::ilogb(unit) / 2.0)));
  return units;
}

ContactProblem contact_in_units(const ContactProblem& contact, const Vector& units) {
  const Matrix G = units.asDiagonal() * dense_inertia(contact.inertia) * units.asDiagonal();
  return {contact.v.cwiseQuotient(units),
          in_units(contact.N, units),
          in_units(contact.D, units),
          contact.edges,
          contact.mu,
          DenseInertia{G}};
}

}  // namespace lcpbench
