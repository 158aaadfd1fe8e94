#include "study/run/open_solver.h"

#include <algorithm>
#include <utility>

#include "adapters/worker/worker_client.h"
#include "core/error.h"
#include "core/same_bits.h"

namespace lcpbench {
namespace {

/// A sweep over more cells ends each worker process after its answer.
constexpr std::size_t kKeptWorkers = 16;
constexpr Index kLargeProblem = 100;  // order of M above which no solver is kept for the next problem

bool same_answer(const Answer& a, const Answer& b) {
  return a.claim == b.claim && a.counters == b.counters && a.detail == b.detail && same_bits(a.z, b.z) &&
         same_bits(a.velocity, b.velocity) && same_bits(a.farkas, b.farkas);
}

/// Adds a cell to those that gave this answer before it.
void add_cell(std::uint32_t cell, TimedAnswer timed, std::vector<SweptAnswer>& answers) {
  const auto known = std::ranges::find_if(
      answers, [&](const SweptAnswer& other) { return same_answer(other.timed.answer, timed.answer); });
  if (known == answers.end()) {
    answers.push_back({{cell}, std::move(timed)});
    return;
  }
  known->cells.push_back(cell);
  SolveTimes& mean = known->timed.times;
  for (double SolveTimes::*time : {&SolveTimes::setup_wall_s, &SolveTimes::setup_cpu_s, &SolveTimes::solve_wall_s,
                                   &SolveTimes::solve_cpu_s, &SolveTimes::transport_s}) {
    mean.*time += (timed.times.*time - mean.*time) / static_cast<double>(known->cells.size());
  }
}

}  // namespace

std::string why_unavailable(const RegisteredSolver& solver) {
  if (!solver.unavailable.empty() || solver.in_process()) return solver.unavailable;
  try {
    worker_executable(solver);
    return "";
  } catch (const InputError&) {
    return "its worker " + solver.worker + " is missing or not executable";
  }
}

bool needs_to_be_told(const RegisteredSolver& solver) {
  try {
    solver.definition.changed_settings({});
    return false;
  } catch (const InputError&) {
    return true;
  }
}

bool runs_unasked(const RegisteredSolver& solver) {
  return why_unavailable(solver).empty() && !needs_to_be_told(solver) && !solver.definition.capabilities.captured_only;
}

bool are_timed_once(const std::vector<Spec>& solvers) {
  return std::any_of(solvers.begin(), solvers.end(), [](const Spec& solver) { return solver.name == "external"; });
}

std::unique_ptr<TimedSolver> open_solver(const Spec& spec) {
  const RegisteredSolver& solver = find_solver(spec.name);
  if (const std::string reason = why_unavailable(solver); !reason.empty()) {
    throw InputError("solver '" + spec.name + "' is not available: " + reason);
  }
  const Spec canonical = canonical_solver_spec(spec);
  if (solver.in_process()) return in_process(make_solver(canonical));
  return worker_solver(worker_executable(solver), canonical);
}

std::unique_ptr<TimedSolver> open_for_steps(const Spec& spec) {
  if (!find_solver(spec.name).in_process()) return open_solver(spec);
  return in_steps([canonical = canonical_solver_spec(spec)] { return make_solver(canonical); });
}

void SweptSolver::run(const Problem& problem, const TimedRequest& request, std::vector<SweptAnswer>& answers) {
  answers.clear();
  TimedRequest once = request;
  once.repeat_until_s = 0;
  for (std::size_t cell = 0; cell < open_.size(); ++cell) {
    if (solvers_[cell] == nullptr) solvers_[cell] = open_[cell]();
    TimedAnswer timed;
    solvers_[cell]->run(problem, once, timed);
    if (!keep_ || problem.size() > kLargeProblem) solvers_[cell].reset();
    add_cell(static_cast<std::uint32_t>(cell), std::move(timed), answers);
  }
}

std::unique_ptr<SweptSolver> open_swept_solver(const std::vector<Spec>& cells) {
  const bool keep = find_solver(cells.at(0).name).in_process() || cells.size() <= kKeptWorkers;
  std::vector<OpenCell> open;
  for (const Spec& cell : cells) open.push_back([cell] { return open_solver(cell); });
  return std::make_unique<SweptSolver>(std::move(open), keep);
}

}  // namespace lcpbench
