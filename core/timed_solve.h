#pragma once

#include <functional>
#include <memory>

#include "core/solver.h"

namespace lcpbench {

/// Seconds spent on one problem. Set-up is load() (for matrix solvers: forming M and converting), solve is solve().
/// When `repeats` > 1 each time is the mean over that many calls in a row.
struct SolveTimes {
  double setup_wall_s = 0;
  double setup_cpu_s = 0;  ///< CPU time of the calling thread
  double solve_wall_s = 0;
  double solve_cpu_s = 0;
  double transport_s = 0;  ///< moving problem and answer to and from a worker, wall clock; 0 in process
  int repeats = 1;
};

/// So long short solves are repeated wherever a time is told: `run`, `solve`, `view` and `bench` then tell the same [s].
inline constexpr double kRepeatUntilS = 2e-4;

struct TimedRequest {
  double time_limit_s = 10.0;   ///< on each solve, wall clock
  double repeat_until_s = 0.0;  ///< repeat load and solve until each batch takes this long, CPU (0: once)
  int max_repeats = 1000;
  const Vector* start = nullptr;  ///< SolveRequest::start
};

struct TimedAnswer {
  Answer answer;
  SolveTimes times;
};

/// Wall clock and thread CPU clock [s].
double wall_clock_s();
double thread_cpu_clock_s();

/// While it lives, wall_clock_s() of this thread asks `stop`, and once that is true each reading is 1e12 s after the one
/// before: every solve with a finite time limit ends with kTimeLimit, as soon as it reads the clock.
class StopCheck {
 public:
  explicit StopCheck(std::function<bool()> stop);
  ~StopCheck();
  StopCheck(const StopCheck&) = delete;
  StopCheck& operator=(const StopCheck&) = delete;

 private:
  friend double wall_clock_s();
  std::function<bool()> stop_;
  double leap_s_ = 0;
};

/// Loads and solves under both clocks. The first load and solve give the answer. Unless they took far longer than
/// `repeat_until_s`, they are timed twice more. Where the least of these took less CPU time than `repeat_until_s`, three
/// batches of loads and three of loads with their solves follow (one clock reading around each batch), which together
/// take as long, and the medians of their means are reported, the solve's as their difference: cold caches, the clock's
/// resolution and what other programs do drop out, and no solve gains from what the one before it prepared. Else the
/// median of the three times is. Throws what the solver throws.
void timed_solve(Solver& solver, const Problem& problem, const TimedRequest& request, TimedAnswer& result);

/// Something that answers problems under the clock: a native solver in this process, or a foreign one in its worker.
class TimedSolver {
 public:
  virtual ~TimedSolver() = default;
  /// Never throws for anything the solver does: that is a claim (kCrashed, kTimeLimit, ...).
  virtual void run(const Problem& problem, const TimedRequest& request, TimedAnswer& result) = 0;
};

/// A TimedSolver over a solver in this process. std::bad_alloc and other exceptions become kNumericalFailure with their
/// text as detail. The CPU times of captured answers (Capabilities::captured_only) are NaN: nobody measured them.
std::unique_ptr<TimedSolver> in_process(std::unique_ptr<Solver> solver);

/// The same for consecutive steps of a simulation: a run with a start is the update() of a solver that has solved the
/// problem before, one without a start begins anew. The solver that has taken a step cannot take it again: up to eight
/// more solvers take the same short steps, and the mean of their times is reported.
std::unique_ptr<TimedSolver> in_steps(std::function<std::unique_ptr<Solver>()> make);

}  // namespace lcpbench
