#pragma once

#include "core/contact_problem.h"

namespace lcpbench {

/// Whether the diagonal of G, where it is given whole or by blocks and positive, spans more than 2^50: its entries are
/// then taken for entries in different units. The bounds on rounding in the engines of contact_lemke are norms over all
/// coordinates. O(ngc); allocates nothing.
bool mixes_units(const Inertia& inertia);

/// Powers of two S for which S G S has a diagonal within [1, 4): the problem for the velocity S^-1 v has bit for bit
/// the same M and q. @pre mixes_units(inertia) @param units ngc entries
void write_coordinate_units(const Inertia& inertia, Eigen::Ref<Vector> units);

}  // namespace lcpbench
