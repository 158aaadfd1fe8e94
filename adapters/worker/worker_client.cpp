#include "adapters/worker/worker_client.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include <unistd.h>

#include "adapters/worker/asked_program.h"
#include "adapters/worker/worker_protocol.h"
#include "core/error.h"

namespace lcpbench {
namespace {

using worker::AskedProgram;

/// Timed repetition runs two batches of about `repeat_until_s` CPU time each, and of at most ten times that by the wall
/// clock on a machine no busier than before; a worker may take twice that before it is ended.
constexpr double kRepeatAllowance = 40.0;

/// A worker that has made its solver. @throws std::runtime_error with the reason when there is none.
std::unique_ptr<AskedProgram> start_worker(const std::filesystem::path& executable, const std::string& solver,
                                           const WorkerLimits& limits) {
  auto process = std::make_unique<AskedProgram>(
      std::vector<std::string>{executable.string(), std::to_string(limits.memory_bytes),
                               std::to_string(limits.program_start_s), solver},
      AskedProgram::Channel::kSocket);
  std::string failure;
  try {
    const std::string greeting = process->ask({}, worker::message_size, worker::response_capacity({}),
                                              wall_clock_s() + limits.start_timeout_s + limits.program_start_s);
    const Answer answer = worker::parse_response(greeting, 0, {}).result.answer;
    if (answer.claim != Claim::kSolved) failure = answer.detail;
  } catch (const worker::NoAnswer& none) {
    failure = none.claim() == Claim::kTimeLimit ? "was not ready in time" : none.what();
    failure = "its worker program " + failure;
  } catch (const worker::BadMessage& bad) {
    failure = "the first message of its worker program is not valid: " + std::string(bad.what());
  }
  if (!failure.empty()) throw std::runtime_error(failure);
  return process;
}

class WorkerSolver final : public TimedSolver {
 public:
  WorkerSolver(std::filesystem::path executable, const Spec& solver, const WorkerLimits& limits)
      : executable_(std::move(executable)), solver_name_(solver.name), solver_(solver.text()), limits_(limits) {}

  void run(const Problem& problem, const TimedRequest& timing, TimedAnswer& result) override {
    result = TimedAnswer{};
    const worker::Request request{++sequence_, timing, problem, timing.start != nullptr ? *timing.start : Vector()};
    try {
      if (ask(request, result)) return;
      // It, or the program behind it, died since its last answer: not this problem's doing.
      process_.reset();
      if (!ask(request, result)) throw std::runtime_error("the worker takes no requests");
    } catch (const std::exception& error) {  // what the worker does to a problem is answered, not thrown
      process_.reset();
      result = TimedAnswer{};
      const std::string reason = worker::printable(error.what(), worker::kMaxDetailBytes);
      const std::string name = solver_name_ + ": ";
      throw WorkerError("solver '" + solver_name_ + "' does not start: " +
                        (reason.starts_with(name) ? reason.substr(name.size()) : reason));
    }
  }

 private:
  void start_if_needed(double time_limit_s) {
    if (process_ && process_->idle()) return process_->forget_messages();
    process_.reset();
    WorkerLimits limits = limits_;
    limits.program_start_s = solver_name_ == "external" ? std::max(limits_.program_start_s, time_limit_s) : 0;
    process_ = start_worker(executable_, solver_, limits);
  }

  /// False when the worker did not begin with the problem.
  bool ask(const worker::Request& request, TimedAnswer& result) {
    start_if_needed(request.timing.time_limit_s);
    const double allowed_s =
        request.timing.time_limit_s + kRepeatAllowance * request.timing.repeat_until_s + limits_.grace_s;
    const worker::AnswerSizes sizes = worker::answer_sizes(request.problem);
    const double begin_s = wall_clock_s();
    const double cpu_before_s = process_->cpu_s();
    const auto give_up = [&](Claim claim, const std::string& detail) {
      result = TimedAnswer{};
      result.times.solve_wall_s = wall_clock_s() - begin_s;
      process_->end();
      result.times.solve_cpu_s = std::max(0.0, process_->cpu_s() - cpu_before_s);
      result.answer.claim = claim;
      result.answer.detail = worker::printable(detail, worker::kMaxDetailBytes);
    };
    try {
      const std::string reply = process_->ask(worker::write_request(request), worker::message_size,
                                              worker::response_capacity(sizes), begin_s + allowed_s);
      worker::Response response = worker::parse_response(reply, request.sequence, sizes);
      if (response.declined) return false;
      result = std::move(response.result);
      result.times.transport_s = std::max(0.0, wall_clock_s() - begin_s - response.busy_s);
      if (response.retiring || result.answer.claim == Claim::kCrashed) process_.reset();
    } catch (const worker::NoAnswer& none) {
      give_up(none.claim(), none.what());
    } catch (const worker::BadMessage& bad) {
      give_up(Claim::kCrashed, "sent what is no answer: " + std::string(bad.what()) + process_->messages());
    }
    return true;
  }

  std::filesystem::path executable_;
  std::string solver_name_;
  std::string solver_;
  WorkerLimits limits_;
  std::uint64_t sequence_ = 0;
  std::unique_ptr<AskedProgram> process_;
};

}  // namespace

std::filesystem::path worker_directory() {
  if (const char* directory = std::getenv("LCPBENCH_WORKER_DIR"); directory != nullptr && *directory != '\0') {
    return directory;
  }
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

std::unique_ptr<TimedSolver> worker_solver(const std::filesystem::path& executable, const Spec& solver,
                                           const WorkerLimits& limits) {
  return std::make_unique<WorkerSolver>(executable, solver, limits);
}

std::string why_not_opened(const std::string& known, const std::string& solver, const std::string& worker) {
  const std::filesystem::path executable = worker_directory() / worker;
  if (!known.empty() || access(executable.c_str(), X_OK) != 0) return known;
  try {
    start_worker(executable, solver, {.program_start_s = 0});
    return {};
  } catch (const std::exception& error) {
    return worker::printable(error.what(), worker::kMaxDetailBytes);
  }
}

std::filesystem::path worker_executable(const RegisteredSolver& solver) {
  const std::string& name = solver.definition.name;
  if (solver.in_process()) throw InputError("solver '" + name + "' runs in this process: it has no worker");
  if (!solver.unavailable.empty()) throw InputError("solver '" + name + "' is not available: " + solver.unavailable);
  std::filesystem::path executable = worker_directory() / solver.worker;
  if (access(executable.c_str(), X_OK) != 0) {
    throw InputError("solver '" + name + "': its worker " + executable.string() + " is missing or not executable");
  }
  return executable;
}

}  // namespace lcpbench
