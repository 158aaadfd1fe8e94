#include "tests/adapters/worker_empty_poll.h"

#include <atomic>
#include <ctime>

#include <poll.h>
#include <signal.h>
#include <sys/wait.h>

namespace lcpbench {
namespace {

std::atomic<pid_t> g_child = -1;
std::atomic<bool> g_ended = false;

void end_stopped(pid_t child) {
  siginfo_t info{};
  waitid(P_PID, static_cast<id_t>(child), &info, WSTOPPED | WEXITED | WNOWAIT);
  kill(child, SIGCONT);
  g_ended = waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOWAIT) == 0;
}

}  // namespace

void end_stopped_child_in_next_empty_poll(pid_t child) {
  g_ended = false;
  g_child = child;
}

bool child_has_ended_in_empty_poll() { return g_ended; }

}  // namespace lcpbench

/// In place of the C library's. By ppoll, since not every processor's Linux has the older call.
extern "C" int poll(pollfd* descriptors, nfds_t count, int timeout_ms) {
  const timespec timeout{.tv_sec = timeout_ms / 1000, .tv_nsec = timeout_ms % 1000 * 1'000'000};
  const int ready = ppoll(descriptors, count, timeout_ms < 0 ? nullptr : &timeout, nullptr);
  if (ready != 0) return ready;
  if (const pid_t child = lcpbench::g_child.exchange(-1); child > 0) lcpbench::end_stopped(child);
  return 0;
}
