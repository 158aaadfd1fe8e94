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
/// An engine for make_model_engine(): python/lcpbench/_model_engine.py.
constexpr const char* kPythonsMujoco = "python3 -m lcpbench._model_engine";
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

namespace {

std::filesystem::path executable_of(const std::string& engine) {
  return worker_directory() / ("lcpbench-capture-" + engine);
}

EngineRun run_program_of(const std::string& engine, const std::string& command,
                         const std::vector<std::string>& arguments, const volatile std::sig_atomic_t* stop) {
  // Of a fixed size: what is written past its end is refused.
  const worker::UniqueFd messages(memfd_create("lcpbench-stderr", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!messages || ftruncate(messages.get(), kMessageBytes) != 0 ||
      fcntl(messages.get(), F_ADD_SEALS, F_SEAL_GROW) != 0) {
    throw std::system_error(errno, std::generic_category(), "cannot start " + executable_of(engine).string());
  }
  const worker::UniqueFd nothing(open("/dev/null", O_WRONLY | O_CLOEXEC));
  std::vector<std::string> words{executable_of(engine).string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  words.push_back(command);
  const std::string ending = worker::run_program(words, nothing.get(), messages.get(), stop);
  return {ending, last_line(messages.get())};
}

/// Whether Python has MuJoCo, and our package to step it.
bool python_has_mujoco(const volatile std::sig_atomic_t* stop) {
  const worker::UniqueFd nothing(open("/dev/null", O_WRONLY | O_CLOEXEC));
  return worker::run_program({"/usr/bin/env", "python3", "-c", "import lcpbench._model_engine"}, nothing.get(),
                             nothing.get(), stop) == "exited with code 0";
}

}  // namespace

EngineRun run_engine(const Spec& engine, const std::vector<std::string>& arguments,
                     const volatile std::sig_atomic_t* stop) {
  const bool is_there = access(executable_of(engine.name).c_str(), X_OK) == 0;
  const std::string missing = "engine '" + engine.name + "' is not available: its program " +
                              executable_of(engine.name).string() +
                              " is missing; install the engine's library and build again";
  const std::string command = engine.options.empty() ? "" : engine.options.front().second;
  const bool of_mujoco = engine.name == "mujoco" && !arguments[1].empty();
  if (!is_there && !of_mujoco) throw InputError(missing);
  constexpr std::size_t kTrack = 6;
  // Python's capture has today's MuJoCo. A replay, of which it would take every step, would cost several times as much.
  if (of_mujoco && arguments[kTrack].empty() && python_has_mujoco(stop)) {
    return run_program_of("external", kPythonsMujoco, arguments, stop);
  }
  EngineRun run{"", missing};
  if (is_there) run = run_program_of(engine.name, command, arguments, stop);
  // MuJoCo as it was built against may be too old for the model: then the one of PyPI.
  if (!of_mujoco || (is_there && run.message.find(" does not read it: ") == std::string::npos)) return run;
  if (python_has_mujoco(stop)) return run_program_of("external", kPythonsMujoco, arguments, stop);
  throw InputError(run.message +
                   " (today's MuJoCo reads it where Python has the packages lcpbench and mujoco: `pip "
                   "install . mujoco` in a checkout of lcpbench)");
}

}  // namespace lcpbench::capture
