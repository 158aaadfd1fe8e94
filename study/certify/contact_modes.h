#pragma once

#include <cstddef>
#include <vector>

#include "core/contact_problem.h"

namespace lcpbench::exact {

/// The bases of all combinations of what each contact may do: part (with and without a slip bound at work), slide along
/// one friction column, or stick between two neighbouring ones (one, where there are but two). None when there would be
/// more than `limit`.
std::vector<std::vector<Index>> contact_modes(const ContactProblem& problem, std::size_t limit);

}  // namespace lcpbench::exact
