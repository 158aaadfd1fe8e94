#include "adapters/worker/exit_status.h"

#include <cerrno>
#include <cstring>

#include <sys/wait.h>

namespace lcpbench::worker {
namespace {

constexpr const char* kUnknown = "ended in an unknown way";

std::string describe_exit(int status) {
  if (WIFEXITED(status)) return "exited with code " + std::to_string(WEXITSTATUS(status));
  if (!WIFSIGNALED(status)) return kUnknown;
  const int signal = WTERMSIG(status);
  const char* name = sigabbrev_np(signal);
  return "killed by signal " + std::to_string(signal) + (name != nullptr ? " (SIG" + std::string(name) + ")" : "");
}

}  // namespace

std::string reap(pid_t child) {
  int status = 0;
  pid_t reaped = 0;
  do {
    reaped = waitpid(child, &status, 0);
  } while (reaped < 0 && errno == EINTR);
  return reaped < 0 ? kUnknown : describe_exit(status);
}

}  // namespace lcpbench::worker
