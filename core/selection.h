#pragma once

#include <span>
#include <vector>

#include "core/contact_problem.h"

namespace lcpbench {

// Parts of contact problems. Indices are not checked.

/// 0, 1, ..., count - 1.
std::vector<Index> all_indices(Index count);

/// J(rows, columns), in their order. @pre no row twice
Jacobian part_of(const Jacobian& J, const std::vector<Index>& rows, const std::vector<Index>& columns);

/// The inertia on these coordinates: the principal part of G (of G* where only that is given), or the rows of X without
/// the factors that are zero on them. Its inverse is the part of the inverse only if nothing couples these coordinates
/// to others. @pre coordinates ascend
Inertia inertia_on(const Inertia& inertia, const std::vector<Index>& coordinates);

/// The same of separate bodies, in O(log blocks) for each block that some coordinate is in.
/// @param begins  block_begins(inertia): the first coordinate of each block, and the number of all
/// @param part  becomes the part; its memory is used again
void blocks_on(const BlockInertia& inertia, const std::vector<Index>& begins, std::span<const Index> coordinates,
               BlockInertia& part);
std::vector<Index> block_begins(const BlockInertia& inertia, std::vector<Index> memory = {});

/// The indices of the columns of D that belong to these contacts, contact by contact.
std::vector<Index> directions_of(const ContactProblem& problem, const std::vector<Index>& contacts);

/// These contacts in the order given, some perhaps twice, on all coordinates, with all bounded rows.
ContactProblem select_contacts(const ContactProblem& problem, const std::vector<Index>& contacts);

/// All contacts with these bounded rows. @pre no row of friction without the row that bounds it
ContactProblem select_rows(const ContactProblem& problem, const std::vector<Index>& kept);

/// All contacts on these coordinates: the other coordinates' rows of N, D and of G (of G* where only that is given) are
/// left out, which keeps the solutions only if nothing couples the two. Factors of the inertia that are zero on the
/// ones that stay are left out, too. @pre coordinates ascend
ContactProblem select_coordinates(const ContactProblem& problem, const std::vector<Index>& coordinates);

}  // namespace lcpbench
