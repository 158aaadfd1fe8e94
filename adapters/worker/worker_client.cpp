#include "adapters/worker/worker_client.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include <unistd.h>

#include "adapters/worker/worker_channel.h"
#include "adapters/worker/worker_process.h"
#include "adapters/worker/worker_protocol.h"
#include "core/error.h"

namespace lcpbench {
namespace {

using worker::WorkerProcess;

constexpr std::size_t kSmallestRegionBytes = std::size_t{1} << 16;
/// Timed repetition runs two batches of about `repeat_until_s` CPU time each, and of at most ten times that by the wall
/// clock on a machine no busier than before; a worker may take twice that before it is ended.
constexpr double kRepeatAllowance = 40.0;

std::size_t rounded_up(std::size_t bytes, std::size_t multiple) { return (bytes + multiple - 1) / multiple * multiple; }

std::string seconds_text(double seconds) { return format_real(std::round(seconds * 1e3) / 1e3) + " s"; }

class WorkerSolver final : public TimedSolver {
 public:
  WorkerSolver(std::filesystem::path executable, const Spec& solver, const WorkerLimits& limits)
      : executable_(std::move(executable)), solver_name_(solver.name), limits_(limits) {
    request_.solver = solver.text();
  }

  void run(const Problem& problem, const TimedRequest& timing, TimedAnswer& result) override {
    result = TimedAnswer{};
    request_.problem = problem;
    request_.timing = timing;
    ++request_.sequence;
    std::string failure;
    try {
      start_if_needed();
      exchange(result);
    } catch (const worker::SolverNotMade& error) {
      failure = "does not start: " + without_name(error.what());
    } catch (const std::exception& error) {  // what the worker does to a problem is answered, not thrown
      failure = "does not start: " + worker::printable(error.what(), worker::kMaxDetailBytes);
    }
    if (!failure.empty()) {
      stop();
      region_ = worker::SharedRegion();
      result = TimedAnswer{};
    }
    request_.problem = Problem();
    if (!failure.empty()) throw WorkerError("solver '" + solver_name_ + "' " + failure);
  }

 private:
  void start_if_needed() {
    if (process_ && !process_->dead()) return;
    stop();
    WorkerLimits limits = limits_;
    limits.program_start_s =
        std::min(limits_.program_start_s, std::max(limits_.program_start_allowance_s, request_.timing.time_limit_s));
    process_.emplace(executable_, request_.solver, limits);
    const std::vector<std::string>& solvers = process_->greeting().solvers;
    if (std::find(solvers.begin(), solvers.end(), solver_name_) == solvers.end()) {
      throw std::runtime_error(executable_.string() + " has no solver '" + solver_name_ + "'");
    }
  }

  /// A reason that begins with the solver's name, without it.
  std::string without_name(const std::string& reason) const {
    return reason.starts_with(solver_name_ + ": ") ? reason.substr(solver_name_.size() + 2) : reason;
  }

  void stop() {
    process_.reset();
    region_is_shared_ = false;
  }

  void exchange(TimedAnswer& result) {
    if (ask(result)) return;
    // It, or the program behind it, died since its last answer: not this problem's doing.
    stop();
    start_if_needed();
    if (!ask(result)) throw std::runtime_error("the worker takes no requests");
  }

  /// False when the worker did not begin with the problem.
  bool ask(TimedAnswer& result) {
    const worker::AnswerSizes sizes = worker::answer_sizes(request_.problem);
    const double begin_s = wall_clock_s();
    const worker::RequestNotice notice = write_into_region(sizes);
    if (!notify(notice)) return false;
    const double cpu_before_s = process_->cpu_s();
    worker::ResponseNotice reply;
    const WorkerProcess::Wait wait =
        process_->wait(std::as_writable_bytes(std::span(&reply, 1)), begin_s + allowed_s());
    const double elapsed_s = wall_clock_s() - begin_s;
    if (wait.event == WorkerProcess::Event::kPacket) {
      const bool valid = wait.packet_bytes == sizeof reply && reply.magic == worker::kMagic &&
                         reply.sequence == notice.sequence && reply.declined <= 1;
      if (valid && reply.declined == 1) return false;
      if (valid) {
        take_response(notice, sizes, elapsed_s, result);
      } else {
        crashed("sent what is no notice of an answer", result);
      }
      return true;
    }
    const double cpu_s = std::max(0.0, process_->cpu_s() - cpu_before_s);
    if (wait.event == WorkerProcess::Event::kTimeout) {
      crashed("ended from outside after " + seconds_text(elapsed_s), result);
      result.answer.claim = Claim::kTimeLimit;
    } else {
      crashed(process_->dies_by_itself() ? "" : "closed its connection", result);
    }
    result.times.solve_wall_s = elapsed_s;
    result.times.solve_cpu_s = cpu_s;
    return true;
  }

  double allowed_s() const {
    return request_.timing.time_limit_s + kRepeatAllowance * request_.timing.repeat_until_s + limits_.grace_s;
  }

  worker::RequestNotice write_into_region(const worker::AnswerSizes& sizes) {
    worker::RequestNotice notice;
    notice.sequence = request_.sequence;
    notice.request_bytes = worker::write_request(request_, {});
    notice.response_offset = rounded_up(notice.request_bytes, 64);
    notice.response_bytes = worker::response_capacity(sizes);
    const std::size_t needed = notice.response_offset + notice.response_bytes;
    if (region_.bytes().size() < needed) {
      region_ = worker::SharedRegion();
      region_is_shared_ = false;
      region_ = worker::SharedRegion::create(std::max(kSmallestRegionBytes, needed + needed / 4));
    }
    worker::write_request(request_, region_.bytes());
    return notice;
  }

  bool notify(const worker::RequestNotice& notice) {
    process_->clear_messages();
    if (!process_->send(std::as_bytes(std::span(&notice, 1)), region_is_shared_ ? -1 : region_.fd())) return false;
    region_is_shared_ = true;
    return true;
  }

  /// The worker may write while we read: the response is copied out first, and only the copy is looked at.
  void take_response(const worker::RequestNotice& notice, const worker::AnswerSizes& sizes, double elapsed_s,
                     TimedAnswer& result) {
    const std::span<const std::byte> shared = region_.bytes().subspan(notice.response_offset, notice.response_bytes);
    copy_.assign(shared.begin(), shared.end());
    worker::Parsed<worker::Response> response = worker::parse_response(copy_, notice.sequence, sizes);
    if (!response.ok()) return crashed("sent what is no answer: " + response.error, result);
    result = std::move(response.value.result);
    result.times.transport_s = std::max(0.0, elapsed_s - response.value.busy_s);
    if (response.value.retiring || result.answer.claim == Claim::kCrashed) stop();
  }

  /// Ends the worker, if there is one, and answers kCrashed with the cause, how it ended if that was its own doing, and
  /// its last words. No cause: it ended.
  void crashed(const std::string& cause, TimedAnswer& result) {
    std::string detail = cause;
    if (process_) {
      const bool died = process_->dead();
      const std::string ending = process_->end();
      if (cause.empty()) {
        detail = ending + " without an answer";
      } else if (died) {
        detail += "; " + ending;
      }
      detail += process_->messages();
    }
    stop();
    result = TimedAnswer{};
    result.answer.claim = Claim::kCrashed;
    result.answer.detail = worker::printable(detail, worker::kMaxDetailBytes);
  }

  std::filesystem::path executable_;
  std::string solver_name_;
  WorkerLimits limits_;
  worker::Request request_;
  worker::SharedRegion region_;
  bool region_is_shared_ = false;
  std::vector<std::byte> copy_;
  std::optional<WorkerProcess> process_;
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

std::string why_no_worker(const std::filesystem::path& executable, const Spec& solver, const WorkerLimits& limits) {
  try {
    const WorkerProcess process(executable, solver.text(), limits);
    return {};
  } catch (const std::exception& error) {
    return worker::printable(error.what(), worker::kMaxDetailBytes);
  }
}

std::string why_not_opened(const std::string& known, const std::string& solver, const std::string& worker) {
  if (!known.empty()) return known;
  const std::filesystem::path executable = worker_directory() / worker;
  return access(executable.c_str(), X_OK) == 0 ? why_no_worker(executable, {solver, {}}) : "";
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
