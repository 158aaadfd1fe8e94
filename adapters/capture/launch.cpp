#include "adapters/capture/launch.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "adapters/worker/exit_status.h"
#include "adapters/worker/worker_channel.h"
#include "adapters/worker/worker_client.h"
#include "core/error.h"

extern char** environ;

namespace lcpbench::capture {
namespace {

constexpr std::size_t kMessageBytes = 1 << 16;

/// Engines also tell progress and warnings there; what ended the program comes last.
std::string last_line(int file) {
  std::string text(kMessageBytes, '\0');
  const off_t written = std::clamp<off_t>(lseek(file, 0, SEEK_CUR), 0, kMessageBytes);
  const ssize_t read = pread(file, text.data(), static_cast<std::size_t>(written), 0);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(read, 0)));
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.substr(text.rfind('\n') + 1);
}

bool runs(pid_t child) {
  siginfo_t ended{};
  return waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid == 0;
}

}  // namespace

EngineRun run_engine(const std::string& engine, const std::vector<std::string>& arguments,
                     const volatile std::sig_atomic_t* stop) {
  const std::filesystem::path executable = worker_directory() / ("lcpbench-capture-" + engine);
  if (access(executable.c_str(), X_OK) != 0) {
    throw InputError("engine '" + engine + "' is not available: its program " + executable.string() +
                     " is missing; install the engine's library and build again");
  }
  const worker::UniqueFd messages = worker::sealed_memory_file("lcpbench-stderr", kMessageBytes);
  std::vector<std::string> words{executable.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, messages.get(), STDERR_FILENO);
  pid_t child = -1;
  const int error = posix_spawn(&child, executable.c_str(), &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw InputError("cannot start " + executable.string() + ": " + std::strerror(error));
  constexpr useconds_t kLook = 10'000;  // microseconds
  while (runs(child) && *stop == 0) usleep(kLook);
  if (*stop != 0) kill(child, SIGTERM);
  const std::string ending = worker::reap(child);
  return {ending, last_line(messages.get())};
}

}  // namespace lcpbench::capture
