#pragma once

#include <vector>

#include "study/inspect/inspection.h"

namespace lcpbench {

/// Facts of a contact problem that its LCP does not show. O(ngc^3 + ngc n^2) up to kLargestDense coordinates and
/// unknowns, else counts only.
/// @param scene  where the problem came from one: its bodies; else they are read off the inertia
ContactFacts contact_facts(const ContactProblem& problem, const RigidScene* scene = nullptr);

/// The impulses without the second of each pair of opposite friction columns, as rows of M.
std::vector<Index> independent_rows(const ContactProblem& problem);

}  // namespace lcpbench
