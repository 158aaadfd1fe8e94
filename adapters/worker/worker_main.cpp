// The main function of every worker: `WORKER MEMORY_BYTES PROGRAM_START_S SOLVER`, with its end of the socket at
// descriptor AskedProgram::kSocketFd. MEMORY_BYTES limits its address space; PROGRAM_START_S is program_start_s(). It
// has the solvers that it is linked with. The one of the spec SOLVER is made before the first request is read, so that
// its construction is in no problem's time, and no problem is blamed if it cannot be made.

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <string>
#include <string_view>

#include <signal.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "adapters/worker/asked_program.h"
#include "adapters/worker/child_processes.h"
#include "adapters/worker/self_timed.h"
#include "adapters/worker/start_directory.h"
#include "adapters/worker/worker_protocol.h"
#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench::worker {
namespace {

constexpr int kExitUsage = 2;
constexpr int kExitProtocol = 70;
/// The largest file that a library may write [bytes].
constexpr rlim_t kFileBytes = 4096;

void limit(decltype(RLIMIT_AS) resource, rlim_t value) {
  const rlimit both{value, value};
  setrlimit(resource, &both);
}

std::filesystem::path g_start_directory;
double g_program_start_s = 0;

/// Limits the address space of this process (see kMemoryIsLimited) and the size of its files, forbids core dumps, and
/// enters /proc.
void confine(rlim_t memory_bytes) {
  if (kMemoryIsLimited) limit(RLIMIT_AS, memory_bytes);
  limit(RLIMIT_CORE, 0);
  rlimit size{};
  getrlimit(RLIMIT_FSIZE, &size);
  size.rlim_cur = std::min(kFileBytes, size.rlim_max);  // an external program may be allowed more
  setrlimit(RLIMIT_FSIZE, &size);
  signal(SIGXFSZ, SIG_IGN);
  if (chdir("/proc") != 0 && chdir("/") != 0) _exit(kExitProtocol);  // nobody, not even root, can make files in /proc
}

/// Ends all descendants of this process that it can find (see end_children()), then this process.
[[noreturn]] void leave(int exit_code = 0) {
  end_children();
  _exit(exit_code);
}

/// False when lcpbench is gone.
bool send_message(const Response& response) {
  const std::string message = write_response(response);
  std::string_view unsent = message;
  while (!unsent.empty()) {
    const ssize_t sent = send(AskedProgram::kSocketFd, unsent.data(), unsent.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno != EINTR) return false;
    if (sent > 0) unsent.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

/// Reads until the text has this size. False when lcpbench is gone.
bool receive(std::string& text, std::size_t size) {
  std::size_t at = text.size();
  text.resize(size);
  while (at < size) {
    const ssize_t received = recv(AskedProgram::kSocketFd, text.data() + at, size - at, MSG_WAITALL);
    if (received == 0 || (received < 0 && errno != EINTR)) return false;
    if (received > 0) at += static_cast<std::size_t>(received);
  }
  return true;
}

/// The next request. Ends this process when lcpbench is gone. @throws BadMessage
Request next_request() {
  std::string message;
  if (!receive(message, kFrameBytes) || !receive(message, message_size(message))) leave();
  return parse_request(message);
}

/// Makes the solver of this spec and sends the first message, which says that it is made. Where it cannot be made, the
/// message says why, and this process ends.
std::unique_ptr<Solver> greet(const std::string& spec) {
  std::unique_ptr<Solver> solver;
  Response greeting;
  greeting.result.answer.claim = Claim::kSolved;
  try {
    solver = make_solver(parse_spec(spec));
  } catch (const std::exception& error) {
    greeting.result.answer.claim = Claim::kUnsupported;
    greeting.result.answer.detail = error.what();
  }
  if (!send_message(greeting) || solver == nullptr) leave();
  return solver;
}

/// @param self_timed  the solver's, nullptr where it is none
void solve(Solver& solver, SelfTimed* self_timed, const Request& request, Response& response) {
  const double begin_s = wall_clock_s();
  const double cpu_begin_s = thread_cpu_clock_s();
  const auto fail = [&](Claim claim, const std::string& detail) {
    response.result = TimedAnswer{};
    response.result.answer.claim = claim;
    response.result.answer.detail = detail;
    response.result.times.solve_wall_s = wall_clock_s() - begin_s;
    response.result.times.solve_cpu_s = thread_cpu_clock_s() - cpu_begin_s;
    response.retiring = true;
  };
  try {
    TimedRequest timing = request.timing;
    if (request.start.size() > 0) timing.start = &request.start;
    if (self_timed != nullptr) {
      self_timed->run(request.problem, timing, response.result);
      response.retiring = !self_timed->usable();
    } else {
      timed_solve(solver, request.problem, timing, response.result);
    }
    const std::string lengths = wrong_lengths(response.result.answer, answer_sizes(request.problem));
    if (!lengths.empty()) fail(Claim::kCrashed, "returned no answer: " + lengths);
  } catch (const std::bad_alloc&) {
    fail(Claim::kNumericalFailure, "out of memory");
  } catch (const std::exception& error) {
    fail(Claim::kNumericalFailure, std::string("exception: ") + error.what());
  } catch (...) {
    fail(Claim::kNumericalFailure, "exception of an unknown type");
  }
  response.busy_s = std::max(0.0, wall_clock_s() - begin_s - response.result.times.transport_s);
}

[[noreturn]] void serve(Solver& solver) {
  auto* const self_timed = dynamic_cast<SelfTimed*>(&solver);
  for (;;) {
    const Request request = next_request();
    Response response;
    response.sequence = request.sequence;
    response.declined = self_timed != nullptr && !self_timed->usable();
    if (!response.declined) solve(solver, self_timed, request, response);
    if (!send_message(response) || response.declined || response.retiring) leave();
  }
}

/// Returns only where the arguments are wrong in number.
int run(int argc, char** argv) {
  if (argc != 4) {
    std::fputs("This is a worker of lcpbench; lcpbench starts it.\n", stderr);
    return kExitUsage;
  }
  std::error_code none;
  g_start_directory = std::filesystem::current_path(none);
  g_program_start_s = std::strtod(argv[2], nullptr);
  confine(std::strtoull(argv[1], nullptr, 10));
  const std::unique_ptr<Solver> solver = greet(argv[3]);
  try {
    serve(*solver);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    leave(kExitProtocol);
  }
}

}  // namespace
}  // namespace lcpbench::worker

const std::filesystem::path& lcpbench::start_directory() { return worker::g_start_directory; }
double lcpbench::program_start_s() { return worker::g_program_start_s; }

int main(int argc, char** argv) { return lcpbench::worker::run(argc, argv); }
