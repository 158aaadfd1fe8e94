#pragma once

#include <vector>

#include "core/contact_problem.h"

namespace lcpbench {

/// 0, 1, ..., count - 1.
std::vector<Index> all_indices(Index count);

/// The rows, each once, and the columns of J at these indices, in their order.
Jacobian part_of(const Jacobian& J, const std::vector<Index>& rows, const std::vector<Index>& columns);

/// The columns of D of these contacts, contact by contact.
std::vector<Index> directions_of(const ContactProblem& problem, const std::vector<Index>& contacts);

/// These contacts in the order given, some perhaps twice, on all coordinates.
ContactProblem select_contacts(const ContactProblem& problem, const std::vector<Index>& contacts);

/// All contacts on these coordinates, which ascend. Factors of the inertia that are zero there are left out.
ContactProblem select_coordinates(const ContactProblem& problem, const std::vector<Index>& coordinates);

}  // namespace lcpbench
