#include "adapters/capture/launch.h"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "adapters/worker/start_program.h"
#include "adapters/worker/unique_fd.h"
#include "adapters/worker/worker_client.h"
#include "core/error.h"

namespace lcpbench::capture {
namespace {

constexpr std::size_t kMessageBytes = 1 << 16;
constexpr std::string_view kEngines[] = {"ode", "bullet", "mujoco", "dart"};

/// Engines also tell progress and warnings there; what ended the program comes last.
std::string last_line(int file) {
  std::string text(kMessageBytes, '\0');
  const off_t written = std::clamp<off_t>(lseek(file, 0, SEEK_CUR), 0, kMessageBytes);
  const ssize_t read = pread(file, text.data(), static_cast<std::size_t>(written), 0);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(read, 0)));
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.substr(text.rfind('\n') + 1);
}

}  // namespace

Spec engine_spec(const std::string& text) {
  Spec spec = parse_spec(text);
  const bool external = spec.name == "external" && spec.options.size() == 1 && spec.options.front().first == "command";
  const bool named = spec.options.empty() && std::ranges::count(kEngines, spec.name) > 0;
  if (!external && !named) {
    throw InputError("--engine '" + text + "': expected ode, bullet, mujoco, dart or external{command=...}");
  }
  return spec;
}

EngineRun run_engine(const Spec& engine, const std::vector<std::string>& arguments,
                     const volatile std::sig_atomic_t* stop) {
  const std::filesystem::path executable = worker_directory() / ("lcpbench-capture-" + engine.name);
  if (access(executable.c_str(), X_OK) != 0) {
    throw InputError("engine '" + engine.name + "' is not available: its program " + executable.string() +
                     " is missing; install the engine's library and build again");
  }
  // Of a fixed size: what is written past its end is refused.
  const worker::UniqueFd messages(memfd_create("lcpbench-stderr", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!messages || ftruncate(messages.get(), kMessageBytes) != 0 ||
      fcntl(messages.get(), F_ADD_SEALS, F_SEAL_GROW) != 0) {
    throw std::system_error(errno, std::generic_category(), "cannot start " + executable.string());
  }
  const worker::UniqueFd nothing(open("/dev/null", O_WRONLY | O_CLOEXEC));
  std::vector<std::string> words{executable.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  words.push_back(engine.options.empty() ? "" : engine.options.front().second);
  const std::string ending = worker::run_program(words, nothing.get(), messages.get(), stop);
  return {ending, last_line(messages.get())};
}

}  // namespace lcpbench::capture
