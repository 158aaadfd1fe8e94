#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench {

struct WorkerLimits {
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;  ///< address space of the worker process
  double start_timeout_s = 20.0;  ///< from fork to the worker's greeting, without the program of `external`
  /// How long that program may take for its first answer: as long as the time limit of the problem that it is started
  /// for, but not less than this.
  double program_start_s = 5.0;
  double grace_s = 1.0;  ///< how long past the time limit a worker may take before it is killed
};

/// A worker could not be asked at all: its program is missing or broken (it does not start, does not greet in time,
/// does not have the solver, takes no requests), or this machine has no process, descriptor or memory left for it. No
/// problem is to blame, so this is no answer to one.
class WorkerError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A solver that runs in the worker process of its library. The process starts at the first run and lives on; when it
/// dies, hangs, exits or returns what does not validate, that one run is answered kCrashed (or kTimeLimit), with the
/// signal or exit code as detail, and the next run starts a fresh process. The worker has a copy of the problem, and no
/// memory of this process.
///
/// A worker is killed, and the answer is kTimeLimit, when set-up and solve together are not done within the sum of the
/// time limit, forty times `repeat_until_s`, and the grace. An exception in the worker, also for want of memory, is
/// answered kNumericalFailure with its text; it too costs the process. For a run without a valid answer, also after an
/// exception, times.solve_wall_s and solve_cpu_s tell what it cost until it was given up, set-up included.
///
/// The destructor ends the process. The process also ends with this program, however that ends; children that the
/// library may have started end with the object, unless they left their process group. Of the worker of `external` they
/// end in any case (adapters/worker/child_processes.h).
///
/// Under AddressSanitizer and ThreadSanitizer workers run without a memory limit.
///
/// run() throws WorkerError when there is no worker to ask; a later run tries anew.
///
/// One object per thread; objects in many threads at once are fine, and an object may move between threads.
/// @param executable  the worker's file
std::unique_ptr<TimedSolver> worker_solver(const std::filesystem::path& executable, const Spec& solver,
                                           const WorkerLimits& limits = {});

/// The text of RegisteredSolver::unavailable for a solver whose library belongs to the user and is opened only by its
/// worker: `known` if it is not empty; otherwise the reason, on one line, why a worker that is started for it does not
/// come up; "" when it does. A missing worker program is no reason here: worker_executable reports it. The worker is
/// started and ended again, which takes at most WorkerLimits::start_timeout_s: it starts no program itself.
/// @param solver  spec of the solver @param worker  file name of its program in worker_directory()
std::string why_not_opened(const std::string& known, const std::string& solver, const std::string& worker);

/// Where the programs of foreign libraries are: beside the running program, or in the folder that the environment
/// variable LCPBENCH_WORKER_DIR names.
std::filesystem::path worker_directory();

/// The worker executable of a registered solver, in worker_directory(). @throws InputError when unavailable, native, or
/// not there.
std::filesystem::path worker_executable(const RegisteredSolver& solver);

}  // namespace lcpbench
