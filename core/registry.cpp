#include "core/registry.h"

#include "core/error.h"

namespace lcpbench {

const RegisteredSolver& find_solver(const std::string& name) {
  std::string names;
  for (const RegisteredSolver& solver : registered_solvers()) {
    if (solver.definition.name == name) return solver;
    names += (names.empty() ? "" : ", ") + solver.definition.name;
  }
  throw InputError("unknown solver '" + name + "'; known: " + names);
}

std::unique_ptr<Solver> make_solver(const Spec& spec) {
  const SolverDefinition& definition = find_solver(spec.name).definition;
  if (definition.make == nullptr) throw InputError("solver '" + spec.name + "' runs in a worker process only");
  return definition.make(spec.options);
}

Spec canonical_solver_spec(const Spec& spec) {
  return {spec.name, find_solver(spec.name).definition.changed_settings(spec.options)};
}

}  // namespace lcpbench
