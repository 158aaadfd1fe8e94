#pragma once

#include "study/certify/candidates.h"
#include "study/certify/certificate.h"
#include "study/certify/deadline.h"

namespace lcpbench::exact {

/// Certifies a bare LCP: bases from `lemke` in double and quad, exact Lemke, the contradiction of its inequalities, and
/// the enumeration of all cones, each of the last three up to an order that it can be afforded for.
/// @pre finite data
Certificate certify_bare(const Problem& problem, const Deadline& deadline, Candidates& candidates);

}  // namespace lcpbench::exact
