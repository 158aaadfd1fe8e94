#pragma once

#include <utility>
#include <vector>

#include "study/inspect/inspection.h"

namespace lcpbench {

/// Facts of a contact problem that its LCP does not show. O(ngc^3 + ngc n^2) up to kLargestDense coordinates and
/// unknowns, else counts only.
ContactFacts contact_facts(const ContactProblem& problem);

/// The impulses without the second of each pair of opposite friction columns, as rows of M.
std::vector<Index> independent_rows(const ContactProblem& problem);

/// Islands: contacts that meet in a coordinate, or in coordinates that the inertia couples.
/// @returns their number and the number of contacts in the largest
std::pair<Index, Index> contact_islands(const ContactProblem& problem);

}  // namespace lcpbench
