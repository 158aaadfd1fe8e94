#pragma once

#include <cstddef>
#include <vector>

#include "core/contact_problem.h"

namespace lcpbench::exact {

/// The bases of all combinations of contact modes. A contact may separate (with or without an active slip bound),
/// slide along one friction column, or stick between two neighbouring ones (one, if there are only two). None when
/// there would be more than `limit`.
std::vector<std::vector<Index>> contact_modes(const ContactProblem& problem, std::size_t limit);

}  // namespace lcpbench::exact
