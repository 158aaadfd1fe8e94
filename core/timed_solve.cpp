#include "core/timed_solve.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <exception>
#include <limits>
#include <utility>

namespace lcpbench {
namespace {

/// A call that used less CPU time than this share of its wall clock time spent most of the time waiting.
constexpr double kLeastShare = 0.1;

struct Stopwatch {
  double wall = wall_clock_s();
  double cpu = thread_cpu_clock_s();

  void stop(int calls, double& wall_s, double& cpu_s) const {
    cpu_s = (thread_cpu_clock_s() - cpu) / calls;
    wall_s = (wall_clock_s() - wall) / calls;
  }
};

/// One load and one solve.
void time_once(Solver& solver, const Problem& problem, const SolveRequest& request, Answer& answer, SolveTimes& times) {
  const Stopwatch setup;
  solver.load(problem);
  setup.stop(1, times.setup_wall_s, times.setup_cpu_s);
  const Stopwatch solve;
  solver.solve(request, answer);
  solve.stop(1, times.solve_wall_s, times.solve_cpu_s);
}

/// The CPU time, since a short solve may wait on a busy machine; at least kLeastShare of the wall clock time.
double cost_of_repeating(const SolveTimes& times) {
  return std::max(times.setup_cpu_s + times.solve_cpu_s, kLeastShare * (times.setup_wall_s + times.solve_wall_s));
}

class InProcess final : public TimedSolver {
 public:
  explicit InProcess(std::unique_ptr<Solver> solver) : solver_(std::move(solver)) {}

  void run(const Problem& problem, const TimedRequest& request, TimedAnswer& result) override {
    try {
      timed_solve(*solver_, problem, request, result);
    } catch (const std::exception& error) {
      result = TimedAnswer{};
      result.answer.detail = error.what();
    }
    if (solver_->capabilities().captured_only) {  // nobody measured the engine
      result.times.setup_cpu_s = result.times.solve_cpu_s = std::numeric_limits<double>::quiet_NaN();
    }
  }

 private:
  std::unique_ptr<Solver> solver_;
};

}  // namespace

double wall_clock_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double thread_cpu_clock_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void timed_solve(Solver& solver, const Problem& problem, const TimedRequest& request, TimedAnswer& result) {
  SolveRequest solve_request;
  solve_request.time_limit_s = request.time_limit_s;
  SolveTimes& times = result.times;
  times = SolveTimes{};

  time_once(solver, problem, solve_request, result.answer, times);
  double once = cost_of_repeating(times);
  thread_local Answer again;
  if (!(once < request.repeat_until_s) && times.setup_cpu_s + times.solve_cpu_s < request.repeat_until_s) {
    SolveTimes second;  // kept waiting, or waits by itself: another one tells
    time_once(solver, problem, solve_request, again, second);
    once = std::min(once, cost_of_repeating(second));
  }
  if (!(once < request.repeat_until_s)) return;
  times.repeats = static_cast<int>(std::min<double>(request.max_repeats, std::ceil(request.repeat_until_s / once)));
  const Stopwatch setups;
  for (int i = 0; i < times.repeats; ++i) solver.load(problem);
  setups.stop(times.repeats, times.setup_wall_s, times.setup_cpu_s);
  const Stopwatch both;
  for (int i = 0; i < times.repeats; ++i) {
    solver.load(problem);
    solver.solve(solve_request, again);
  }
  both.stop(times.repeats, times.solve_wall_s, times.solve_cpu_s);
  // The set-up may seem to take longer than set-up and solve together, because both times are measured with noise.
  times.solve_wall_s = std::max(0.0, times.solve_wall_s - times.setup_wall_s);
  times.solve_cpu_s = std::max(0.0, times.solve_cpu_s - times.setup_cpu_s);
}

std::unique_ptr<TimedSolver> in_process(std::unique_ptr<Solver> solver) {
  return std::make_unique<InProcess>(std::move(solver));
}

}  // namespace lcpbench
