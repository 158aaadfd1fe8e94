#pragma once

#include <csignal>
#include <string>
#include <vector>

#include "core/spec.h"

namespace lcpbench::capture {

/// How the program of an engine ended.
struct EngineRun {
  std::string ending;   ///< "exited with code 0", "killed by signal 11 (SIGSEGV)"
  std::string message;  ///< the last line that it wrote to its standard error
};

/// An engine as the option --engine names it: ode, bullet, mujoco, dart, or external{command=...}. @throws InputError
Spec engine_spec(const std::string& text);

/// Runs lcpbench-capture-<engine>, which is in the folder of the worker programs, and waits for its end. If `*stop` is
/// not 0, it ends the program. @param arguments  from SCENE to MARKS, see program.cpp
/// @throws InputError when the program is missing, std::system_error when this machine cannot start another one
EngineRun run_engine(const Spec& engine, const std::vector<std::string>& arguments,
                     const volatile std::sig_atomic_t* stop);

}  // namespace lcpbench::capture
