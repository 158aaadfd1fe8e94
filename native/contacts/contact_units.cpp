#include "native/contacts/contact_units.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

namespace lcpbench {
namespace {

/// Diagonal entries of G that differ by more than this are taken for entries in different units.
constexpr double kSameUnit = 0x1p50;

/// Calls visit(i, G_ii) for G given whole or by blocks; else never.
template <class Visit>
void for_each_diagonal_entry(const Inertia& inertia, Visit&& visit) {
  if (!std::holds_alternative<DenseInertia>(inertia) && !std::holds_alternative<BlockInertia>(inertia)) return;
  for_each_matrix(inertia, [&](const Matrix& G, Index first) {
    for (Index i = 0; i < G.rows(); ++i) visit(first + i, G(i, i));
  });
}

}  // namespace

bool mixes_units(const Inertia& inertia) {
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  for_each_diagonal_entry(inertia, [&](Index, double entry) {
    least = std::min(least, entry);
    most = std::max(most, entry);
  });
  return least > 0 && most > kSameUnit * least;
}

void write_coordinate_units(const Inertia& inertia, Eigen::Ref<Vector> units) {
  for_each_diagonal_entry(inertia, [&](Index i, double entry) {
    units(i) = std::ldexp(1.0, -static_cast<int>(std::floor(std::ilogb(entry) / 2.0)));
  });
}

}  // namespace lcpbench
