#pragma once

#include <string>
#include <vector>

#include "core/problem.h"

namespace lcpbench {

/// An answer itself, for people. Of an LCP of up to 30 rows its z in one line; of contacts a table of the impulses of
/// each and its sliding speed, of the first 20; else "". Lines are as wide as `width` or less, where it is not
/// kUnlimited.
/// @param title  what stands before z @param names  of contacts: one for each, or none
/// @param velocity  after the impact, of contacts @pre z has problem.size() entries
std::string solution_text(const Problem& problem, const std::string& title, const Vector& z, const Vector& velocity,
                          const std::vector<std::string>& names, int width);

/// Whether other impulses may give the velocity, too: false only where the directions of all contacts that it leaves
/// touching are independent. True where that would take more than a second to tell.
bool may_have_other_impulses(const ContactProblem& contact, const Vector& velocity);

/// The share of max(|N'v + b|, |D'v + offset_t|) over the contacts that a speed is [m/s].
double share_of_scale(const ContactProblem& contact, double m_per_s);

}  // namespace lcpbench
