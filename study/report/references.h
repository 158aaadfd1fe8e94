#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "study/report/decision.h"
#include "study/report/summary.h"

// The solver that factors are over: the paper's dense one, unless the reader chooses another one in the page.

namespace lcpbench::report {

/// Where the page's script finds the factor of a solver on a set: the value of data-factor or data-speed.
std::string factor_key(std::size_t set, std::size_t solver);
/// The same for the solver that a situation recommends.
std::string situation_key(std::size_t situation, std::size_t solver);

/// The choice of the reference solver, hidden until the page's script shows it; "" without two solvers to choose from.
std::string reference_choice(const Summary& summary);

/// The factors between all pairs of solvers as JSON in a script element: summed times on the problems that both solved,
/// to three digits, 0 where there are none. Per set the solvers `of`, and for each the factors over the later ones.
/// O(sets x solvers^2 x problems)
std::string reference_data(const Summary& summary, const std::vector<Situation>& situations);

}  // namespace lcpbench::report
