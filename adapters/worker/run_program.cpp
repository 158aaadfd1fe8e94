#include "adapters/worker/run_program.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "adapters/worker/child_processes.h"
#include "adapters/worker/exit_status.h"
#include "core/error.h"

namespace lcpbench::worker {
namespace {

constexpr useconds_t kLook = 10'000;  // microseconds
constexpr int kCannotRun = 127;

bool runs(pid_t child) {
  siginfo_t ended{};
  return waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid == 0;
}

}  // namespace

std::string run_program(std::vector<std::string> words, int output, int messages,
                        const volatile std::sig_atomic_t* stop) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) throw InputError("cannot start " + words.front() + ": " + std::strerror(errno));
  if (child == 0) {
    setpgid(0, 0);
    end_with_parent(parent);
    dup2(open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
    dup2(output, STDOUT_FILENO);
    dup2(messages, STDERR_FILENO);
    execv(pointers.front(), pointers.data());
    _exit(kCannotRun);
  }
  setpgid(child, child);  // in the child too: whoever comes first
  while (runs(child) && *stop == 0) usleep(kLook);
  kill(-child, SIGKILL);  // also what the program started and left behind
  const std::string ending = reap(child);
  if (ending == "exited with code " + std::to_string(kCannotRun)) throw InputError("cannot run " + words.front());
  return ending;
}

}  // namespace lcpbench::worker
