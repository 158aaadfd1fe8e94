// The program of every worker: `WORKER PARENT_PID MEMORY_BYTES PROGRAM_START_S SOLVER`, with its end of the socket at
// kSocketFd. Which solvers it has is decided by the list it is linked with; SOLVER, the spec of the one that will be
// asked for, is made before the greeting, so that no problem pays for it or is blamed when it cannot be made.

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <string>
#include <string_view>

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include "adapters/worker/child_processes.h"
#include "adapters/worker/self_timed.h"
#include "adapters/worker/start_directory.h"
#include "adapters/worker/worker_channel.h"
#include "adapters/worker/worker_protocol.h"
#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench::worker {
namespace {

constexpr int kExitUsage = 2;
constexpr int kExitProtocol = 70;
/// Limit on the bytes that a library may write to one file. The stderr that the main program reads has the same limit.
constexpr rlim_t kFileBytes = 4096;

template <class Number>
bool parse_number(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

void limit(decltype(RLIMIT_AS) resource, rlim_t value) {
  const rlimit both{value, value};
  setrlimit(resource, &both);
}

std::filesystem::path g_start_directory;
double g_program_start_s = 0;

/// Dies with the program, leaves no core and no files behind, takes no more memory than it is given.
void confine(rlim_t memory_bytes) {
  if (kMemoryIsLimited) limit(RLIMIT_AS, memory_bytes);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_FSIZE, kFileBytes);
  signal(SIGXFSZ, SIG_IGN);
  if (chdir("/proc") != 0 && chdir("/") != 0) _exit(kExitProtocol);  // nobody, not even root, can make files in /proc
}

/// Ends this process, and first all that a program that it runs has started.
[[noreturn]] void leave(int exit_code = 0) {
  end_children();
  _exit(exit_code);
}

void greet(const std::string& failure = {}) {
  Greeting greeting;
  greeting.failure = failure;
  for (const RegisteredSolver& solver : registered_solvers()) greeting.solvers.push_back(solver.definition.name);
  std::vector<std::byte> packet(write_greeting(greeting, {}));
  write_greeting(greeting, packet);
  if (!send_packet(kSocketFd, packet)) leave(kExitProtocol);
}

[[noreturn]] void give_up(const std::string& cause) {
  std::fprintf(stderr, "%s\n", cause.c_str());
  leave(kExitProtocol);
}

/// The solver of the last request, kept while its spec stays the same.
class CurrentSolver {
 public:
  Solver& get(const std::string& spec) {
    if (!solver_ || spec != spec_) {
      solver_.reset();
      solver_ = make_solver(parse_spec(spec));
      spec_ = spec;
    }
    return *solver_;
  }

  /// False when the other process that does the solver's work has ended since its last problem.
  bool usable() const {
    const auto* const self_timed = dynamic_cast<const SelfTimed*>(solver_.get());
    return self_timed == nullptr || self_timed->usable();
  }

 private:
  std::string spec_;
  std::unique_ptr<Solver> solver_;
};

bool has_solver(const std::string& name) {
  const std::vector<RegisteredSolver>& solvers = registered_solvers();
  return std::any_of(solvers.begin(), solvers.end(),
                     [&](const auto& solver) { return solver.definition.name == name; });
}

void fail(Response& response, Claim claim, const std::string& detail) {
  response.result = TimedAnswer{};
  response.result.answer.claim = claim;
  response.result.answer.detail = detail;
  response.retiring = true;
}

void solve(CurrentSolver& current, const Request& request, Response& response) {
  const double begin_s = wall_clock_s();
  try {
    Solver& solver = current.get(request.solver);
    if (auto* const self_timed = dynamic_cast<SelfTimed*>(&solver)) {
      self_timed->run(request.problem, request.timing, response.result);
      response.retiring = !self_timed->usable();
    } else {
      timed_solve(solver, request.problem, request.timing, response.result);
    }
    const std::string lengths = wrong_lengths(response.result.answer, answer_sizes(request.problem));
    if (!lengths.empty()) fail(response, Claim::kCrashed, "returned no answer: " + lengths);
  } catch (const std::bad_alloc&) {
    fail(response, Claim::kNumericalFailure, "out of memory");
  } catch (const std::exception& error) {
    fail(response, Claim::kNumericalFailure, std::string("exception: ") + error.what());
  } catch (...) {
    fail(response, Claim::kNumericalFailure, "exception of an unknown type");
  }
  response.busy_s = std::max(0.0, wall_clock_s() - begin_s - response.result.times.transport_s);
}

Response answer(CurrentSolver& current, std::span<const std::byte> request_bytes, std::uint64_t sequence) {
  Response response;
  response.sequence = sequence;
  Parsed<Request> request = parse_request(request_bytes);
  if (!request.ok()) {
    fail(response, Claim::kNumericalFailure, "the request is not valid: " + request.error);
    return response;
  }
  solve(current, request.value, response);
  return response;
}

void check(const RequestNotice& notice, std::size_t region_bytes) {
  if (notice.magic != kMagic) give_up("the notice of a request is not valid");
  if (notice.request_bytes > notice.response_offset || notice.response_offset > region_bytes ||
      notice.response_bytes > region_bytes - notice.response_offset) {
    give_up("the notice of a request does not fit the shared memory");
  }
}

[[noreturn]] void serve(CurrentSolver& current) {
  SharedRegion region;
  for (;;) {
    RequestNotice notice;
    UniqueFd attached;
    const ssize_t received = receive_packet(kSocketFd, std::as_writable_bytes(std::span(&notice, 1)), &attached);
    if (received <= 0) leave();  // the program is gone
    if (received != sizeof notice) give_up("the notice of a request has a wrong size");
    if (attached) {
      region = SharedRegion();
      region = SharedRegion::adopt(std::move(attached));
    }
    check(notice, region.bytes().size());
    ResponseNotice done;
    done.sequence = notice.sequence;
    if (!current.usable()) {
      done.declined = 1;
      send_packet(kSocketFd, std::as_bytes(std::span(&done, 1)));
      leave();
    }
    const Response response = answer(current, region.bytes().first(notice.request_bytes), notice.sequence);
    write_response(response, region.bytes().subspan(notice.response_offset, notice.response_bytes));
    if (!send_packet(kSocketFd, std::as_bytes(std::span(&done, 1)))) leave();
    if (response.retiring) leave();
  }
}

int run(int argc, char** argv) {
  pid_t parent = 0;
  rlim_t memory_bytes = 0;
  if (argc != 5 || !parse_number(argv[1], parent) || !parse_number(argv[2], memory_bytes) ||
      !parse_number(argv[3], g_program_start_s)) {
    std::fputs("This is a worker of lcpbench; lcpbench starts it.\n", stderr);
    return kExitUsage;
  }
  end_with_parent(parent);
  std::error_code none;
  g_start_directory = std::filesystem::current_path(none);
  confine(memory_bytes);
  CurrentSolver current;
  try {
    if (has_solver(parse_spec(argv[4]).name)) current.get(argv[4]);  // else the greeting tells the program so
  } catch (const std::exception& error) {
    greet(error.what());
    leave();
  }
  try {
    greet();
    serve(current);
  } catch (const std::exception& error) {
    give_up(error.what());
  }
}

}  // namespace
}  // namespace lcpbench::worker

const std::filesystem::path& lcpbench::start_directory() { return worker::g_start_directory; }
double lcpbench::program_start_s() { return worker::g_program_start_s; }

int main(int argc, char** argv) { return lcpbench::worker::run(argc, argv); }
