#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench {

struct WorkerLimits {
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;  ///< address space of the worker process
  double start_timeout_s = 20.0;                        ///< from fork to the worker's greeting
  double grace_s = 1.0;  ///< how long past the time limit a worker may take before it is killed
};

/// A solver that runs in the worker process of its library. The process starts at the first run and lives on; when it
/// dies, hangs, exits, outgrows its memory or returns what does not validate, that one run is answered kCrashed (or
/// kTimeLimit), with the signal or exit code as detail, and the next run starts a fresh process. Nothing that the worker
/// does to the shared memory can reach the problem data of this process.
/// @param executable  the worker's file
std::unique_ptr<TimedSolver> worker_solver(const std::filesystem::path& executable, const Spec& solver,
                                           const WorkerLimits& limits = {});

/// The worker executable of a registered solver: beside the running program. @throws InputError when unavailable.
std::filesystem::path worker_executable(const RegisteredSolver& solver);

}  // namespace lcpbench
