#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/registry.h"

namespace lcpbench::testing {

inline Answer solve(const std::string& solver, const Problem& problem) {
  Answer result;
  const std::unique_ptr<Solver> object = make_solver(parse_spec(solver));
  object->load(problem);
  object->solve({.time_limit_s = 60}, result);
  return result;
}

inline std::vector<std::string> native_names() {
  std::vector<std::string> names;
  for (const RegisteredSolver& solver : registered_solvers()) {
    if (solver.native()) names.push_back(solver.definition.name);
  }
  return names;
}

}  // namespace lcpbench::testing
