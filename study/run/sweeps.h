#pragma once

#include <string>
#include <vector>

#include "core/spec.h"

namespace lcpbench {

/// One setting and the values it takes in a grid, in the form that a spec takes.
struct SweepAxis {
  std::string setting;
  std::vector<std::string> values;
};

/// A parameter grid: every combination of its axes' values.
struct Sweep {
  std::string name;
  std::vector<SweepAxis> axes;
};

/// A built-in sweep of a solver. "paper" is the grid of Drumwright and Shell 2012: lemke 9 x 9 over pivot_tolerance and
/// zero_tolerance (1e-20 to 1e-4 in steps of 1e2), primal_dual 3 x 3 over eps and eps_feas (1e-20, 1e-14, 1e-8: steps
/// of 1e6, whose next would be beyond 1e-4), path its one tolerance (1e-20 to 1e-4 in steps of 1e2). A solver that
/// wraps another by a setting `solver` takes the grid of that one. lemke and primal_dual claim as in the paper, with
/// test=none; regularized with test=original unless the spec names another.
/// @throws InputError when the name is unknown, or the solver has no such grid.
Sweep builtin_sweep(const std::string& name, const Spec& solver);

/// True when builtin_sweep would find a grid.
bool has_builtin_sweep(const std::string& name, const Spec& solver);

/// The solver with each combination of the grid in turn, in canonical form; the first axis varies slowest. An axis
/// named "a.b" sets b of the spec that is the value of a.
/// @throws InputError for unknown settings and values out of range.
std::vector<Spec> sweep_cells(const Sweep& sweep, const Spec& solver);

/// The name of a solver's sweep in results, with the settings that the solver had off their defaults:
/// "paper{engine=kernel}".
std::string sweep_label(const std::string& sweep, const Spec& solver);

}  // namespace lcpbench
