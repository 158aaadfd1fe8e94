#include "core/timed_solve.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <exception>
#include <limits>
#include <utility>
#include <vector>

namespace lcpbench {
namespace {

/// A call that used less CPU time than this share of its wall clock time spent most of the time waiting.
constexpr double kLeastShare = 0.1;

/// A first call over so many times `repeat_until_s` is long whatever the caches held: it alone is the time.
constexpr double kFarLonger = 10;

/// The one in the middle of three, by a number of each.
template <class ByNumber>
SolveTimes median(std::array<SolveTimes, 3> times, ByNumber by_number) {
  std::ranges::sort(times, {}, by_number);
  return times[1];
}

thread_local StopCheck* stop_check = nullptr;

struct Stopwatch {
  double wall = wall_clock_s();
  double cpu = thread_cpu_clock_s();

  void stop(int calls, double& wall_s, double& cpu_s) const {
    cpu_s = (thread_cpu_clock_s() - cpu) / calls;
    wall_s = (wall_clock_s() - wall) / calls;
  }
};

/// One load, or update from the step before, and one solve.
void time_once(Solver& solver, const Problem& problem, const SolveRequest& request, Answer& answer, SolveTimes& times,
               bool follows = false) {
  const Stopwatch setup;
  if (follows) {
    solver.update(problem);
  } else {
    solver.load(problem);
  }
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
    if (!solver_->capabilities().captured_only) return;
    const double solve_s =  // that the engine told, if it did
        problem.engine_answer() != nullptr ? problem.engine_answer()->solve_s : std::numeric_limits<double>::quiet_NaN();
    result.times = {};
    result.times.setup_cpu_s = 0 * solve_s;  // in its time, or not known either
    result.times.solve_wall_s = result.times.solve_cpu_s = solve_s;
  }

 private:
  std::unique_ptr<Solver> solver_;
};

class InSteps final : public TimedSolver {
 public:
  explicit InSteps(std::function<std::unique_ptr<Solver>()> make) : make_(std::move(make)) {}

  void run(const Problem& problem, const TimedRequest& request, TimedAnswer& result) override {
    try {
      const bool follows = request.start != nullptr && !solvers_.empty();
      if (!follows) solvers_.clear();
      if (!follows) solvers_.push_back(make_());
      result.times = SolveTimes{};
      take_step(0, problem, request, follows, result.answer, result.times);
      if (!follows) add_companions(request.repeat_until_s, cost_of_repeating(result.times));
      if (solvers_.size() < 2) return;
      result.times = SolveTimes{};  // those of the first contain what the machine had to fetch
      for (std::size_t i = 1; i < solvers_.size(); ++i) take_step(i, problem, request, follows, again_, result.times);
      result.times.repeats = static_cast<int>(solvers_.size()) - 1;
      for (const auto part : kParts) result.times.*part /= result.times.repeats;
    } catch (const std::exception& error) {
      solvers_.clear();
      result = TimedAnswer{};
      result.answer.detail = error.what();
    }
  }

 private:
  static constexpr std::array kParts{&SolveTimes::setup_wall_s, &SolveTimes::setup_cpu_s, &SolveTimes::solve_wall_s,
                                     &SolveTimes::solve_cpu_s};

  void add_companions(double repeat_until_s, double cost_s) {
    constexpr double kMost = 9;
    const double count = std::min(kMost, 1 + std::ceil(repeat_until_s / cost_s));
    if (!(cost_s < repeat_until_s)) return;
    while (static_cast<double>(solvers_.size()) < count) solvers_.push_back(make_());
  }

  /// Adds its times to `sum`.
  void take_step(std::size_t i, const Problem& problem, const TimedRequest& request, bool follows, Answer& answer,
                 SolveTimes& sum) {
    SolveTimes times;
    time_once(*solvers_[i], problem, {.start = request.start, .time_limit_s = request.time_limit_s}, answer, times,
              follows);
    for (const auto part : kParts) sum.*part += times.*part;
  }

  std::function<std::unique_ptr<Solver>()> make_;
  std::vector<std::unique_ptr<Solver>> solvers_;
  Answer again_;
};

}  // namespace

StopCheck::StopCheck(std::function<bool()> stop) : stop_(std::move(stop)) { stop_check = this; }

StopCheck::~StopCheck() { stop_check = nullptr; }

double wall_clock_s() {
  constexpr double kLeap_s = 1e12;
  const double now_s = std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  if (stop_check == nullptr || !stop_check->stop_()) return now_s;
  return now_s + (stop_check->leap_s_ += kLeap_s);
}

double thread_cpu_clock_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void timed_solve(Solver& solver, const Problem& problem, const TimedRequest& request, TimedAnswer& result) {
  const SolveRequest solve_request{.start = request.start, .time_limit_s = request.time_limit_s};
  SolveTimes& times = result.times;
  times = SolveTimes{};

  time_once(solver, problem, solve_request, result.answer, times);
  if (!(times.setup_cpu_s + times.solve_cpu_s < kFarLonger * request.repeat_until_s)) return;
  thread_local Answer again;
  std::array<SolveTimes, 3> measured{times};
  double once = cost_of_repeating(times);
  for (std::size_t i = 1; i < measured.size() && !(once < request.repeat_until_s); ++i) {
    time_once(solver, problem, solve_request, again, measured[i]);
    once = std::min(once, cost_of_repeating(measured[i]));
  }
  if (!(once < request.repeat_until_s)) {
    times = median(measured, [](const SolveTimes& each) { return each.setup_cpu_s + each.solve_cpu_s; });
    return;
  }
  const double batches = measured.size();
  const double repeats = std::ceil(std::min<double>(request.max_repeats, request.repeat_until_s / once) / batches);
  const int calls = static_cast<int>(repeats);
  for (SolveTimes& batch : measured) {
    const Stopwatch setups;
    for (int i = 0; i < calls; ++i) solver.load(problem);
    setups.stop(calls, batch.setup_wall_s, batch.setup_cpu_s);
    const Stopwatch both;
    for (int i = 0; i < calls; ++i) {
      solver.load(problem);
      solver.solve(solve_request, again);
    }
    both.stop(calls, batch.solve_wall_s, batch.solve_cpu_s);
  }
  times = median(measured, [](const SolveTimes& batch) { return batch.solve_cpu_s; });
  const SolveTimes setup = median(measured, [](const SolveTimes& batch) { return batch.setup_cpu_s; });
  times.repeats = calls * static_cast<int>(measured.size());
  times.setup_wall_s = setup.setup_wall_s;
  times.setup_cpu_s = setup.setup_cpu_s;
  // The set-up may seem to take longer than set-up and solve together, because both times are measured with noise.
  times.solve_wall_s = std::max(0.0, times.solve_wall_s - times.setup_wall_s);
  times.solve_cpu_s = std::max(0.0, times.solve_cpu_s - times.setup_cpu_s);
}

std::unique_ptr<TimedSolver> in_process(std::unique_ptr<Solver> solver) {
  return std::make_unique<InProcess>(std::move(solver));
}

std::unique_ptr<TimedSolver> in_steps(std::function<std::unique_ptr<Solver>()> make) {
  return std::make_unique<InSteps>(std::move(make));
}

}  // namespace lcpbench
