#include "study/run/open_solver.h"

#include <algorithm>
#include <utility>

#include "adapters/worker/worker_client.h"
#include "core/error.h"
#include "core/swept_answers.h"

namespace lcpbench {
namespace {

/// A sweep over more cells ends each worker process after its answer.
constexpr std::size_t kKeptWorkers = 16;
constexpr Index kLargeProblem = 100;  // order of M above which no solver is kept for the next problem

/// nullptr where the solver has no way to share work between these cells.
std::unique_ptr<SweptSolver> shared_sweep(const RegisteredSolver& solver, const std::vector<Spec>& cells) {
  if (!solver.native() || solver.definition.make_swept == nullptr) return nullptr;
  std::vector<Options> options;
  for (const Spec& cell : cells) options.push_back(canonical_solver_spec(cell).options);
  return solver.definition.make_swept(options);
}

/// See one_by_one().
class OneByOne final : public SweptSolver {
 public:
  OneByOne(std::vector<OpenCell> cells, bool keep) : open_(std::move(cells)), keep_(keep), solvers_(open_.size()) {}

  void run(const Problem& problem, const TimedRequest& request, std::vector<SweptAnswer>& answers) override {
    SweptAnswers gathered(answers);
    TimedRequest once = request;
    once.repeat_until_s = 0;
    for (std::size_t cell = 0; cell < open_.size(); ++cell) {
      if (solvers_[cell] == nullptr) solvers_[cell] = open_[cell]();
      TimedAnswer timed;
      solvers_[cell]->run(problem, once, timed);
      if (!keep_ || problem.size() > kLargeProblem) solvers_[cell].reset();
      gathered.add({static_cast<std::uint32_t>(cell)}, std::move(timed));
    }
    gathered.finish();
  }

 private:
  std::vector<OpenCell> open_;
  bool keep_;
  std::vector<std::unique_ptr<TimedSolver>> solvers_;
};

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

std::unique_ptr<SweptSolver> open_swept_solver(const std::vector<Spec>& cells) {
  const RegisteredSolver& solver = find_solver(cells.at(0).name);
  if (std::unique_ptr<SweptSolver> shared = shared_sweep(solver, cells)) return shared;
  std::vector<OpenCell> open;
  for (const Spec& cell : cells) open.push_back([cell] { return open_solver(cell); });
  return one_by_one(std::move(open), solver.in_process() || cells.size() <= kKeptWorkers);
}

std::unique_ptr<SweptSolver> one_by_one(std::vector<OpenCell> cells, bool keep) {
  return std::make_unique<OneByOne>(std::move(cells), keep);
}

}  // namespace lcpbench
