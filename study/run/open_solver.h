#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench {

/// Why the solver cannot run here: its library was not found when this was built, its worker program is
/// missing, or a library of the user's own does not open; "" when it can run.
std::string why_unavailable(const RegisteredSolver& solver);

/// Whether a setting of the solver has no default, as the command of `external`: such a solver runs only where the user
/// names it.
bool needs_to_be_told(const RegisteredSolver& solver);

/// Whether the solver can run here without being named: it is available, every setting has a default, and it takes more
/// than captured steps.
bool runs_unasked(const RegisteredSolver& solver);

/// Whether one of these is a program of the user's, the solver `external`. It may remember problems that it has seen,
/// so it is asked each one once. To be fair all solvers beside it are then timed once and cold as well.
bool are_timed_once(const std::vector<Spec>& solvers);

/// Any registered solver, under the clock: native ones in this process, foreign ones in their worker.
/// @throws InputError for an unknown name, bad settings, or a solver that cannot run here (with the reason).
std::unique_ptr<TimedSolver> open_solver(const Spec& spec);

/// The same for consecutive steps, each from the last answer: see in_steps().
std::unique_ptr<TimedSolver> open_for_steps(const Spec& spec);

/// Makes the solver of one cell of a sweep.
using OpenCell = std::function<std::unique_ptr<TimedSolver>()>;

/// One distinct answer of a sweep, and the cells that gave it.
struct SweptAnswer {
  std::vector<std::uint32_t> cells;  ///< their numbers in the sweep, ascending
  TimedAnswer timed;                 ///< with the mean times of these cells
};

/// Answers a problem at the cells of a sweep (one solver with different settings each) one after the other, each with a
/// solver of its own. A solver is opened when its cell first runs. It is kept for the next problem unless the problem
/// has more than 100 rows or `keep` is false: dozens of workspaces, or worker processes, would add up.
class SweptSolver {
 public:
  SweptSolver(std::vector<OpenCell> cells, bool keep)
      : open_(std::move(cells)), keep_(keep), solvers_(open_.size()) {}

  /// @param answers set: no two are equal in claim, vectors (bit for bit), counters and detail. Ordered by their first
  /// cell.
  /// `request.repeat_until_s` is not used: cells run once. `request.time_limit_s` holds for each cell.
  void run(const Problem& problem, const TimedRequest& request, std::vector<SweptAnswer>& answers);

 private:
  std::vector<OpenCell> open_;
  bool keep_;
  std::vector<std::unique_ptr<TimedSolver>> solvers_;
};

/// Any registered solver over the cells of a sweep. The workers of up to 16 cells live on between small problems; those
/// of larger sweeps end with each answer.
/// @pre at least one cell, and all of the same solver
/// @throws InputError for an unknown name; else a cell throws as open_solver does when it first runs
std::unique_ptr<SweptSolver> open_swept_solver(const std::vector<Spec>& cells);

}  // namespace lcpbench
