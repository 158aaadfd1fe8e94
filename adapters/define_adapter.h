#pragma once

#include <utility>

#include "core/registry.h"

namespace lcpbench {

/// Completes a definition for either of the two programs that an adapter's file is compiled for: the worker, which has
/// the library, and the main program, which only describes the solver. There SolverType is declared and never defined.
template <class SolverType, class Settings>
SolverDefinition define_adapter(SolverDefinition definition) {
#ifdef LCPBENCH_DESCRIBE_ONLY
  return with_settings<Settings>(std::move(definition));
#else
  return define_solver<SolverType, Settings>(std::move(definition));
#endif
}

}  // namespace lcpbench
