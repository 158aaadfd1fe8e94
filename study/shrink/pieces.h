#pragma once

#include <vector>

#include "core/problem.h"

namespace lcpbench {

// Smaller problems of the same kind. `kept` holds ascending indices. What is left out is gone from every field, and
// what stays has the numbers that it had.

/// Contacts of a contact problem or a scene; rows of a bare LCP.
Index contact_count(const Problem& problem);
Problem with_contacts(const Problem& problem, const std::vector<Index>& kept);

/// Bounded rows of a contact problem.
Index row_count(const Problem& problem);
/// Friction goes with the row that bears it.
Problem with_rows(const Problem& problem, const std::vector<Index>& kept);

/// Bodies of a scene; coordinates of a contact problem. A bare LCP has neither.
Index body_count(const Problem& problem);
/// The others do not move any more: they become parts of the world, and a contact within the world is left out.
Problem with_bodies(const Problem& problem, const std::vector<Index>& kept);

/// Factors of an inertia that is given by factors; 0 for others.
Index factor_count(const Problem& problem);
Problem with_factors(const Problem& problem, const std::vector<Index>& kept);

/// Contacts with friction edges, also those with mu = 0; none of a bare LCP.
std::vector<Index> frictional_contacts(const Problem& problem);
/// Friction stays at these contacts.
Problem with_friction(const Problem& problem, const std::vector<Index>& kept);

/// Contacts with more than two friction edges, of a kind of problem that can have fewer.
std::vector<Index> contacts_of_many_edges(const Problem& problem);
/// All edges stay at the contacts in `kept`. The others lose every second one, or all but one pair where those that
/// stay would not be pairs.
Problem with_fewer_edges(const Problem& problem, const std::vector<Index>& kept);

}  // namespace lcpbench
