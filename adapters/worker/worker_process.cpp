#include "adapters/worker/worker_process.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstring>
#include <ctime>
#include <functional>
#include <future>
#include <mutex>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "adapters/worker/exit_status.h"

extern char** environ;

namespace lcpbench::worker {
namespace {

/// How often a waiting program looks whether the worker died although something still holds its socket open.
constexpr double kDeathCheckPeriod_s = 0.05;
/// How long a worker that closed its socket is given to be seen as dead of its own cause.
constexpr double kLastWords_s = 0.2;
/// How long a worker that is asked to end is given to end its program's processes, before it is killed.
constexpr double kFarewell_s = 0.5;
constexpr std::size_t kStderrBytes = 4096;
constexpr std::size_t kStderrTail = 300;
/// Descriptors that pass to the worker are moved here first, clear of the numbers they get there.
constexpr int kLowestPassedFd = 10;

/// The one thread that starts all workers. Never destroyed: it ends with the program.
class Starter {
 public:
  static Starter& instance() {
    static auto* starter = new Starter;
    return *starter;
  }

  int run(std::function<int()> task) {
    std::packaged_task<int()> packaged(std::move(task));
    std::future<int> result = packaged.get_future();
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
    pthread_sigmask(SIG_SETMASK, &all, &before);  // inherited by the thread: signals go to the others
    std::thread([this] { serve(); }).detach();
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }

  [[noreturn]] void serve() {
    for (;;) {
      std::unique_lock lock(mutex_);
      work_.wait(lock, [this] { return !tasks_.empty(); });
      std::packaged_task<int()> task = std::move(tasks_.front());
      tasks_.erase(tasks_.begin());
      lock.unlock();
      task();
    }
  }

  std::mutex mutex_;
  std::condition_variable work_;
  std::vector<std::packaged_task<int()>> tasks_;
};

/// The environment of a worker: ours, with the numerical libraries held to one thread.
std::vector<std::string> worker_environment() {
  const std::array<std::string, 3> ours{"OPENBLAS_NUM_THREADS=1", "OMP_NUM_THREADS=1", "MKL_NUM_THREADS=1"};
  std::vector<std::string> result(ours.begin(), ours.end());
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text(*entry);
    const bool replaced = std::any_of(ours.begin(), ours.end(), [&](const std::string& own) {
      return text.starts_with(std::string_view(own).substr(0, own.find('=') + 1));
    });
    if (!replaced) result.emplace_back(text);
  }
  return result;
}

std::vector<char*> null_terminated(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  pointers.reserve(texts.size() + 1);
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

class FileActions {
 public:
  FileActions() { posix_spawn_file_actions_init(&actions_); }
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
  const posix_spawn_file_actions_t* get() const { return &actions_; }

  void wire(int socket, int stderr_file) {
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions_, stderr_file, STDERR_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, socket, kSocketFd);
    posix_spawn_file_actions_addclosefrom_np(&actions_, kSocketFd + 1);
  }

 private:
  posix_spawn_file_actions_t actions_{};
};

class SpawnAttributes {
 public:
  SpawnAttributes() {
    posix_spawnattr_init(&attributes_);
    sigset_t none;
    sigset_t all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~SpawnAttributes() { posix_spawnattr_destroy(&attributes_); }
  SpawnAttributes(const SpawnAttributes&) = delete;
  SpawnAttributes& operator=(const SpawnAttributes&) = delete;
  const posix_spawnattr_t* get() const { return &attributes_; }

 private:
  posix_spawnattr_t attributes_{};
};

int spawn(const std::string& executable, std::vector<std::string> arguments, int socket, int stderr_file, pid_t& pid) {
  std::vector<std::string> environment = worker_environment();
  FileActions actions;
  actions.wire(socket, stderr_file);
  const SpawnAttributes attributes;
  return posix_spawn(&pid, executable.c_str(), actions.get(), attributes.get(), null_terminated(arguments).data(),
                     null_terminated(environment).data());
}

UniqueFd moved_up(UniqueFd fd) {
  UniqueFd moved(fcntl(fd.get(), F_DUPFD_CLOEXEC, kLowestPassedFd));
  if (!moved) throw std::system_error(errno, std::generic_category(), "no free file descriptor");
  return moved;
}

int poll_timeout_ms(double seconds) {
  return static_cast<int>(std::ceil(std::clamp(seconds, 0.0, kDeathCheckPeriod_s) * 1e3));
}

}  // namespace

WorkerProcess::WorkerProcess(const std::filesystem::path& executable, const std::string& solver,
                             const WorkerLimits& limits) {
  start(executable, solver, limits);
  try {
    expect_greeting(limits.start_timeout_s);
  } catch (...) {
    end();
    throw;
  }
}

WorkerProcess::~WorkerProcess() { end(); }

void WorkerProcess::start(const std::filesystem::path& executable, const std::string& solver,
                          const WorkerLimits& limits) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw std::system_error(errno, std::generic_category(), "socketpair");
  }
  socket_ = UniqueFd(ends[0]);
  const UniqueFd worker_end = moved_up(UniqueFd(ends[1]));
  stderr_file_ = moved_up(sealed_memory_file("lcpbench-stderr", kStderrBytes));

  const std::vector<std::string> arguments{executable.string(), std::to_string(getpid()),
                                           std::to_string(limits.memory_bytes), std::to_string(limits.program_start_s),
                                           solver};
  const int error = Starter::instance().run(
      [&] { return spawn(executable.string(), arguments, worker_end.get(), stderr_file_.get(), pid_); });
  if (error != 0) {
    pid_ = -1;
    throw std::runtime_error("cannot start " + executable.string() + ": " + std::strerror(error));
  }
}

void WorkerProcess::expect_greeting(double timeout_s) {
  std::vector<std::byte> packet(kMaxGreetingBytes);
  const Wait greeted = wait(packet, wall_clock_s() + timeout_s);
  if (greeted.event == Event::kTimeout) throw std::runtime_error("its worker program was not ready in time");
  if (greeted.event == Event::kEnded) {
    const std::string ending = end();
    throw std::runtime_error("its worker program " + ending + " before it was ready" + messages());
  }
  if (greeted.packet_bytes > packet.size())
    throw std::runtime_error("the first message of its worker program is too long");
  Parsed<Greeting> greeting = parse_greeting(std::span(packet).first(greeted.packet_bytes));
  if (!greeting.ok())
    throw std::runtime_error("the first message of its worker program is not valid: " + greeting.error);
  greeting_ = std::move(greeting.value);
  if (!greeting_.failure.empty()) throw SolverNotMade(greeting_.failure);
}

WorkerProcess::Wait WorkerProcess::wait(std::span<std::byte> packet, double deadline_s) {
  for (bool ended = false;;) {
    const double left = deadline_s - wall_clock_s();
    pollfd polled{socket_.get(), POLLIN, 0};
    const int ready = poll(&polled, 1, ended ? 0 : poll_timeout_ms(left));
    if (ready > 0) {
      const ssize_t received = receive_packet(socket_.get(), packet, nullptr, MSG_DONTWAIT);
      if (received > 0) return {Event::kPacket, static_cast<std::size_t>(received)};
      if (received == 0 || errno != EAGAIN) return {Event::kEnded, 0};
    } else if (ended && ready == 0) {
      return {Event::kEnded, 0};
    } else if (dead()) {
      ended = true;  // it may have answered after poll() looked: once more
    } else if (!(left > 0)) {
      return {Event::kTimeout, 0};
    }
  }
}

bool WorkerProcess::dead() const {
  if (pid_ < 0) return true;
  siginfo_t info{};
  if (waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) != 0) return errno == ECHILD;
  return info.si_pid == pid_;
}

bool WorkerProcess::dies_by_itself() const {
  const double deadline_s = wall_clock_s() + kLastWords_s;
  while (!dead()) {
    if (wall_clock_s() > deadline_s) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

double WorkerProcess::cpu_s() const {
  clockid_t clock{};
  timespec time{};
  if (pid_ < 0 || clock_getcpuclockid(pid_, &clock) != 0 || clock_gettime(clock, &time) != 0) return 0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::string WorkerProcess::end() {
  if (pid_ < 0) return {};
  kill(pid_, SIGTERM);
  kill(pid_, SIGCONT);
  const double deadline_s = wall_clock_s() + kFarewell_s;
  while (!dead() && wall_clock_s() < deadline_s) std::this_thread::sleep_for(std::chrono::microseconds(200));
  socket_.reset();
  kill(-pid_, SIGKILL);
  kill(pid_, SIGKILL);
  return reap(std::exchange(pid_, -1));
}

void WorkerProcess::clear_messages() { lseek(stderr_file_.get(), 0, SEEK_SET); }

std::string WorkerProcess::messages() const {
  const off_t written = std::clamp<off_t>(lseek(stderr_file_.get(), 0, SEEK_CUR), 0, kStderrBytes);
  std::string text(std::min(kStderrTail, static_cast<std::size_t>(written)), '\0');
  const ssize_t read = pread(stderr_file_.get(), text.data(), text.size(), written - static_cast<off_t>(text.size()));
  text = printable(std::string_view(text).substr(0, static_cast<std::size_t>(std::max<ssize_t>(read, 0))), kStderrTail);
  text.erase(text.find_last_not_of(' ') + 1);
  return text.empty() ? "" : "; stderr: " + text;
}

}  // namespace lcpbench::worker
