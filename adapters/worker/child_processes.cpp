#include "adapters/worker/child_processes.h"

#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <string_view>

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/timed_solve.h"

namespace lcpbench::worker {
namespace {

// A signal handler must not allocate memory: hence system calls and fixed buffers instead of opendir() and streams.

constexpr double kPatience_s = 0.333;
constexpr timespec kPause{.tv_sec = 0, .tv_nsec = 1'000'000};
constexpr std::size_t kListBytes = 4096;
constexpr std::size_t kStatBytes = 512;

/// Whether a process is a child of this one. @param processes  /proc  @param name  its process number, an entry there
bool is_child(int processes, const char* name) {
  const int process = openat(processes, name, O_PATH | O_DIRECTORY | O_CLOEXEC);
  const int file = openat(process, "stat", O_RDONLY | O_CLOEXEC);
  char text[kStatBytes];
  const ssize_t count = read(file, text, sizeof text);
  close(file);
  close(process);
  // "PID (NAME) STATE PARENT ...", where NAME may itself contain parentheses and spaces
  constexpr std::size_t kFromNameToParent = 4;  // ") S "
  const std::string_view stat(text, count > 0 ? static_cast<std::size_t>(count) : 0);
  const std::size_t name_end = stat.rfind(')');
  if (name_end == std::string_view::npos || stat.size() < name_end + kFromNameToParent) return false;
  pid_t parent = 0;
  std::from_chars(stat.data() + name_end + kFromNameToParent, stat.data() + stat.size(), parent);
  return parent == getpid();
}

void kill_children() {
  const int processes = open("/proc", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (processes < 0) return;
  alignas(std::uint64_t) char list[kListBytes];
  for (;;) {
    const long bytes = syscall(SYS_getdents64, processes, list, sizeof list);
    if (bytes <= 0) break;
    // struct linux_dirent64, which no header of the C library declares: inode, offset, record length, type, name
    constexpr std::size_t kLengthAt = 16;
    constexpr std::size_t kNameAt = 19;
    for (long at = 0; at < bytes;) {
      std::uint16_t length = 0;
      std::memcpy(&length, list + at + kLengthAt, sizeof length);
      const char* const name = list + at + kNameAt;
      pid_t process = 0;
      const auto [end, error] = std::from_chars(name, name + std::strlen(name), process);
      if (error == std::errc() && *end == '\0' && is_child(processes, name)) kill(process, SIGKILL);
      at += length;
    }
  }
  close(processes);
}

/// Reaps all children that have ended. Returns whether there are others, which still run.
bool reap_children() {
  for (;;) {
    const pid_t reaped = waitpid(-1, nullptr, WNOHANG);
    if (reaped == 0) return true;
    if (reaped < 0 && errno != EINTR) return false;
  }
}

}  // namespace

void adopt_orphans() { prctl(PR_SET_CHILD_SUBREAPER, 1); }

void reap_orphans(pid_t program) {
  for (;;) {
    siginfo_t info{};
    const int failed = waitid(P_ALL, 0, &info, WEXITED | WNOHANG | WNOWAIT);
    if (failed != 0 || info.si_pid == 0 || info.si_pid == program) return;
    waitpid(info.si_pid, nullptr, 0);
  }
}

void end_children() {
  const double deadline_s = wall_clock_s() + kPatience_s;
  while (reap_children()) {
    kill_children();
    if (wall_clock_s() >= deadline_s) return;  // counted rounds would not do: reading /proc may take long
    nanosleep(&kPause, nullptr);
  }
}

}  // namespace lcpbench::worker
