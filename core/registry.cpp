#include "core/registry.h"

#include <vector>

#include "core/error.h"
#include "core/suggestion.h"

namespace lcpbench {

const RegisteredSolver& find_solver(const std::string& name) {
  for (const RegisteredSolver& solver : registered_solvers()) {
    if (solver.definition.name == name) return solver;
  }
  std::vector<std::string> known;
  std::string list;
  for (const RegisteredSolver& solver : registered_solvers()) {
    known.push_back(solver.definition.name);
    list += (list.empty() ? "" : ", ") + known.back();
  }
  throw InputError("unknown solver '" + name + "'" + did_you_mean(name, known) + "; known: " + list +
                   "; the answer that a captured step has from its engine, by any name, is 'engine'");
}

std::unique_ptr<Solver> make_solver(const Spec& spec) {
  const RegisteredSolver& registered = find_solver(spec.name);
  const SolverDefinition& definition = registered.definition;
  if (definition.make == nullptr) throw InputError("solver '" + spec.name + "' runs in a worker process only");
  std::unique_ptr<Solver> solver = definition.make(spec.options);
  if (registered.native()) solver->require_proofs();
  return solver;
}

Spec canonical_solver_spec(const Spec& spec) {
  return {spec.name, find_solver(spec.name).definition.changed_settings(spec.options)};
}

}  // namespace lcpbench
