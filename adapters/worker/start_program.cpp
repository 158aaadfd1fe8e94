#include "adapters/worker/start_program.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <linux/close_range.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "adapters/worker/unique_fd.h"
#include "core/error.h"

extern char** environ;

namespace lcpbench::worker {
namespace {

constexpr useconds_t kLook_us = 10'000;  ///< between two looks whether a program has ended
/// Descriptors that pass to the program are moved here first, clear of the numbers they get there.
constexpr int kLowestPassedFd = 10;

/// The one thread that starts all programs: PR_SET_PDEATHSIG (see become()) ends a program with the thread that started
/// it, not with the process. Never destroyed: it ends with the process. It takes no signals.
class Starter {
 public:
  static Starter& instance() {
    static auto* starter = new Starter;
    return *starter;
  }

  pid_t run(std::function<pid_t()> task) {
    std::packaged_task<pid_t()> packaged(std::move(task));
    std::future<pid_t> result = packaged.get_future();
    {
      const std::lock_guard lock(mutex_);
      tasks_.push_back(std::move(packaged));
    }
    work_.notify_one();
    return result.get();
  }

 private:
  Starter() {
    sigset_t all;
    sigset_t before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);  // inherited by the thread
    const auto restore = [](sigset_t* mask) { pthread_sigmask(SIG_SETMASK, mask, nullptr); };
    const std::unique_ptr<sigset_t, decltype(restore)> restored(&before, restore);  // also if no thread can start
    std::thread([this] { serve(); }).detach();
  }

  [[noreturn]] void serve() {
    for (;;) {
      std::unique_lock lock(mutex_);
      work_.wait(lock, [this] { return !tasks_.empty(); });
      std::packaged_task<pid_t()> task = std::move(tasks_.front());
      tasks_.erase(tasks_.begin());
      lock.unlock();
      task();
    }
  }

  std::mutex mutex_;
  std::condition_variable work_;
  std::vector<std::packaged_task<pid_t()>> tasks_;
};

/// Our environment, with the numerical libraries held to one thread.
std::vector<std::string> environment() {
  std::vector<std::string> result{"OPENBLAS_NUM_THREADS=1", "OMP_NUM_THREADS=1", "MKL_NUM_THREADS=1"};
  const auto sets = [](std::string_view entry, std::string_view own) {
    return entry.starts_with(own.substr(0, own.find('=') + 1));
  };
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (std::none_of(result.begin(), result.begin() + 3, [&](const auto& own) { return sets(*entry, own); })) {
      result.emplace_back(*entry);
    }
  }
  return result;
}

std::vector<char*> null_terminated(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

UniqueFd moved_up(int fd) {
  UniqueFd moved(fcntl(fd, F_DUPFD_CLOEXEC, kLowestPassedFd));
  if (!moved) throw std::system_error(errno, std::generic_category(), "no free file descriptor");
  return moved;
}

/// All that the child needs, made before it is.
struct Child {
  pid_t parent;
  const char* folder;  ///< nullptr: it stays in ours
  bool leads_session;
  std::vector<int> descriptors;
  std::vector<char*> words;
  std::vector<char*> environment;
  int failure;  ///< the pipe that takes a Failure
};

struct Failure {
  bool in_folder = false;  ///< the folder could not be entered; else the program could not be run
  int cause = 0;           ///< errno
};

/// The child's way into its program. It runs in the memory of its parent, which waits: so it makes system calls only.
[[noreturn]] void become(const Child& child) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != child.parent) _exit(0);  // it died before the line above
  struct sigaction action {};
  action.sa_handler = SIG_DFL;
  for (int signal = 1; signal < NSIG; ++signal) {
    // Where this process ignores SIGXFSZ the program does too: a file over its size limit is then a failed write.
    if (signal != SIGXFSZ) sigaction(signal, &action, nullptr);
  }
  if (child.leads_session) setsid();
  Failure failure;
  failure.in_folder = child.folder != nullptr && chdir(child.folder) != 0;
  if (!failure.in_folder) {
    int next = 0;
    for (const int descriptor : child.descriptors) dup2(descriptor, next++);
    close_range(static_cast<unsigned>(next), ~0U, CLOSE_RANGE_CLOEXEC);
    sigprocmask(SIG_SETMASK, &action.sa_mask, nullptr);
    execvpe(child.words[0], child.words.data(), child.environment.data());
  }
  failure.cause = errno;
  [[maybe_unused]] const ssize_t told = write(child.failure, &failure, sizeof failure);
  _exit(127);
}

}  // namespace

pid_t start_program(const ProgramStart& start) {
  std::vector<std::string> words = start.words;
  std::vector<std::string> variables = environment();
  std::vector<UniqueFd> passed;
  for (const int descriptor : start.descriptors) passed.push_back(moved_up(descriptor));
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  const UniqueFd read_end(ends[0]);
  UniqueFd write_end(ends[1]);
  write_end = moved_up(write_end.get());
  Child child{getpid(), start.folder.empty() ? nullptr : start.folder.c_str(), start.leads_session, {},
              null_terminated(words), null_terminated(variables), write_end.get()};
  for (const UniqueFd& descriptor : passed) child.descriptors.push_back(descriptor.get());

  const pid_t id = Starter::instance().run([&child]() -> pid_t {
    const pid_t process = vfork();
    if (process == 0) become(child);
    if (process < 0) {
      throw std::system_error(errno, std::generic_category(), "cannot start " + lcpbench::printable(child.words[0]));
    }
    return process;
  });
  write_end.reset();
  Failure failure;
  if (read(read_end.get(), &failure, sizeof failure) != sizeof failure) return id;
  reap(id);
  throw InputError("cannot run " + words[0] + (failure.in_folder ? " in " + start.folder.string() : "") + ": " +
                   std::strerror(failure.cause));
}

bool has_ended(pid_t child) {
  siginfo_t info{};
  if (waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) != 0) return errno == ECHILD;
  return info.si_pid == child;
}

bool was_told_to_end(pid_t child) {
  siginfo_t info{};
  if (waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) != 0) return false;
  const bool by_signal = info.si_pid == child && (info.si_code == CLD_KILLED || info.si_code == CLD_DUMPED);
  return by_signal && (info.si_status == SIGTERM || info.si_status == SIGKILL || info.si_status == SIGINT);
}

std::string reap(pid_t child) {
  int status = 0;
  pid_t reaped = 0;
  do {
    reaped = waitpid(child, &status, 0);
  } while (reaped < 0 && errno == EINTR);
  if (reaped >= 0 && WIFEXITED(status)) return "exited with code " + std::to_string(WEXITSTATUS(status));
  if (reaped < 0 || !WIFSIGNALED(status)) return "ended in an unknown way";
  const int signal = WTERMSIG(status);
  const char* name = sigabbrev_np(signal);
  return "killed by signal " + std::to_string(signal) + (name != nullptr ? " (SIG" + std::string(name) + ")" : "");
}

std::string run_program(const std::vector<std::string>& words, int output, int messages,
                        const volatile std::sig_atomic_t* stop) {
  const UniqueFd nothing(open("/dev/null", O_RDONLY | O_CLOEXEC));
  const pid_t child = start_program(
      {.words = words, .descriptors = {nothing.get(), output, messages}, .leads_session = true});
  while (!has_ended(child) && *stop == 0) usleep(kLook_us);
  kill(-child, SIGKILL);  // also what the program started and left behind
  return reap(child);
}

}  // namespace lcpbench::worker
