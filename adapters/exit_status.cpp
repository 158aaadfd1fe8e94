#include "adapters/exit_status.h"

#include <cstring>

#include <sys/wait.h>

namespace lcpbench::worker {

std::string describe_exit(int status) {
  if (WIFEXITED(status)) return "exited with code " + std::to_string(WEXITSTATUS(status));
  if (!WIFSIGNALED(status)) return "ended in an unknown way";
  const int signal = WTERMSIG(status);
  const char* name = sigabbrev_np(signal);
  return "killed by signal " + std::to_string(signal) + (name != nullptr ? " (SIG" + std::string(name) + ")" : "");
}

}  // namespace lcpbench::worker
