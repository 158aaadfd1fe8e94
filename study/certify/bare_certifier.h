#pragma once

#include "study/certify/candidates.h"
#include "study/certify/certificate.h"
#include "study/certify/deadline.h"

namespace lcpbench::exact {

/// Certifies a bare LCP: bases from `lemke` in double and quad, exact Lemke, the contradiction of its inequalities, and
/// the enumeration of all cones. Each of the last three has a limit on the order.
/// @pre finite data
Certificate certify_bare(const Problem& problem, const Deadline& deadline, Candidates& candidates);

}  // namespace lcpbench::exact
