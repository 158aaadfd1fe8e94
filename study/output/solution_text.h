#pragma once

#include <string>
#include <vector>

#include "core/problem.h"
#include "study/evaluation/bounded_row_states.h"
#include "study/output/json_output.h"

namespace lcpbench {

/// An answer itself, for people. Of an LCP of up to 30 rows its z in one line; of contacts a table of the impulses of
/// each and its sliding speed, of the first 20; else "". Lines are as wide as `width` or less, where it is not
/// kUnlimited.
/// Of bounded rows, too, a table of the impulse and velocity of each and its place between its bounds, of the first 20.
/// @param title  what stands before z @param names  of contacts: one for each, or none
/// @param velocity  after the impact, of contacts @pre z has problem.size() entries
std::string solution_text(const Problem& problem, const std::string& title, const Vector& z, const Vector& velocity,
                          const std::vector<std::string>& names, int width);

/// Whether other impulses may give the velocity, too: false only where the directions of all contacts that it leaves
/// touching, and of all bounded rows that it leaves at rest, are independent. True where that would take more than
/// a second to tell.
bool may_have_other_impulses(const ContactProblem& contact, const Vector& velocity);

/// For each bounded row: number, name, unit, bounds, impulse, velocity w and state.
Json row_states_json(const BoundedRows& rows, const std::vector<BoundedRowState>& states);

/// The share of max(|N'v + b|, |D'v + offset_t|) over the contacts that a speed is [m/s].
double share_of_scale(const ContactProblem& contact, double m_per_s);

}  // namespace lcpbench
