#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

#include <fcntl.h>
#include <unistd.h>

#include "adapters/capture/launch.h"
#include "adapters/capture/scene.h"
#include "adapters/worker/unique_fd.h"
#include "core/io/problem_io.h"
#include "core/io/scenes_file.h"
#include "core/io/whole_file.h"
#include "core/registry.h"
#include "study/commands/commands.h"

namespace lcpbench {
namespace {

struct CaptureArguments {
  std::string scene;
  std::string engine;
  std::string model;
  std::int64_t every = 10;
  std::int64_t steps = 0;
  std::string loop = "engine";
  std::string soft;
  std::string out;
};

/// Completes what was not given. @throws InputError on an unknown scene
void complete(CaptureArguments& arguments) {
  if (!arguments.model.empty() && !std::filesystem::is_regular_file(arguments.model)) {
    throw InputError(fmt::format("--model '{}': no such file", arguments.model));
  }
  if (arguments.loop != "engine") {
    const Spec spec = canonical_solver_spec(parse_spec(arguments.loop));
    if (!find_solver(spec.name).native()) {
      throw InputError(fmt::format("--loop '{}': expected engine, or a solver of lcpbench's own", arguments.loop));
    }
    arguments.loop = spec.text();
  }
  if (!arguments.soft.empty() && arguments.loop != "engine") {
    throw InputError("--soft: the engine's own contacts are captured where the engine solves them, not with --loop");
  }
  const std::string first = !arguments.model.empty() ? "mujoco" : capture::find_scene(arguments.scene).engine();
  if (arguments.engine.empty()) arguments.engine = first;
  const std::string engine = capture::engine_spec(arguments.engine).name;
  if (arguments.out.empty()) arguments.out = fmt::format("{}-{}.scenes", parse_spec(arguments.scene).name, engine);
  if (!is_scenes_file(arguments.out)) {
    throw InputError(fmt::format("--out '{}': a scenes file's name ends in .scenes", arguments.out));
  }
}

/// A file for the engine's program to write, which has no name: it is gone when this process ends, however that ends.
class NamelessFile {
 public:
  /// @param folder  on whose disk it lies. @throws InputError
  explicit NamelessFile(const std::filesystem::path& folder) {
    std::string name = (folder / ".lcpbench-XXXXXX").string();
    file_ = worker::UniqueFd(mkostemp(name.data(), O_CLOEXEC));
    if (!file_) throw InputError(fmt::format("{}: cannot be written to: {}", folder.string(), std::strerror(errno)));
    unlink(name.c_str());
  }
  /// Under which the engine's program finds it too.
  std::string name() const { return fmt::format("/proc/{}/fd/{}", getpid(), file_.get()); }

 private:
  worker::UniqueFd file_;
};

/// Whether the file has its first line whole, the header; without it there is no step.
bool has_header(const std::string& raw) {
  std::ifstream stream(raw);
  std::string line;
  return std::getline(stream, line) && !stream.eof();
}

/// Steps are read to compress them: after an interrupt a longer text stays as the engine wrote it.
constexpr std::uintmax_t kCompressedBytes = std::uintmax_t{1} << 23;

/// Reads every step, and writes the file. @returns how many steps
std::size_t compress(const std::string& raw, const std::string& out) {
  const ScenesFile captured(raw);
  if (captured.count() == 0) return 0;
  ScenesWriter writer(out, captured.header());
  for (std::size_t i = 0; i < captured.count(); ++i) writer.add(captured.read(i));
  writer.close();
  return captured.count();
}

/// @param model  the user's, or empty
std::string why_no_contact(const std::string& model) {
  if (model.empty()) return "none of the steps that were looked at has a contact of a body that can move";
  std::ifstream stream(model);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (text.find("<robot") == std::string::npos) {
    return "nothing in " + model +
           " touched anything: does it have a ground, a body that can move, and shapes that may collide?";
  }
  return "nothing touched anything: " + model +
         " is a URDF. It has no ground, and MuJoCo fixes its root link to the world. Put these two lines behind <robot "
         "...>, with the name of the root link for BASE and the height of its origin for 0.5:\n"
         "  <link name=\"world\"><collision><origin xyz=\"0 0 -0.5\"/><geometry><box size=\"20 20 1\"/></geometry>"
         "</collision></link>\n"
         "  <joint name=\"free\" type=\"floating\"><parent link=\"world\"/><child link=\"BASE\"/>"
         "<origin xyz=\"0 0 0.5\"/></joint>";
}

/// The file's place; of a capture that did not come to its end only where no other file stands, else a name beside it.
std::filesystem::path place_of(const WholeFile& out, bool complete) {
  std::filesystem::path place = out.place();
  if (!complete && out.had_content()) place.replace_extension(".incomplete.scenes");
  return place;
}

int run_capture(CaptureArguments arguments) {
  complete(arguments);
  const volatile std::sig_atomic_t* stop = catch_interrupts(kExitInterrupted);
  WholeFile out(arguments.out);
  std::filesystem::path folder = out.place().parent_path();
  if (folder.empty()) folder = ".";
  const NamelessFile steps(folder);
  const std::vector<std::string> words{arguments.scene,
                                       arguments.model,
                                       std::to_string(arguments.every),
                                       std::to_string(arguments.steps),
                                       steps.name(),
                                       arguments.loop,
                                       "",
                                       arguments.soft,
                                       ""};
  const Spec engine = capture::engine_spec(arguments.engine);
  const capture::EngineRun run = capture::run_engine(engine, words, stop);
  if (run.ending == "exited with code 2") throw InputError(run.message);
  const bool interrupted = *stop != 0;
  const bool crashed = !interrupted && run.ending != "exited with code 0";
  if (crashed) {
    say(stderr, "lcpbench: {} {}{}\n", engine.name, run.ending, run.message.empty() ? "" : ": " + run.message);
  } else if (!interrupted && !run.message.empty()) {
    say(stderr, "lcpbench: {} said: {}\n", engine.name, run.message);
  }
  const bool as_written = interrupted && std::filesystem::file_size(steps.name()) > kCompressedBytes;
  std::size_t count = 0;
  if (as_written) {
    std::filesystem::copy_file(steps.name(), out.draft(), std::filesystem::copy_options::overwrite_existing);
    count = ScenesFile(out.draft().string()).count();
  } else if (has_header(steps.name())) {
    count = compress(steps.name(), out.draft().string());
  }
  if (count == 0) {
    const bool untouched = !interrupted && !crashed;
    say(stderr, "lcpbench: no step of '{}' was captured{}\n", arguments.scene,
        untouched ? ": " + why_no_contact(arguments.model) : "");
    return interrupted ? kExitInterrupted : kExitCheckFailed;
  }
  const ScenesFile written(out.draft().string());
  const std::filesystem::path place = place_of(out, !interrupted && !crashed);
  out.commit_as(place);
  const std::string name = place == out.place() ? arguments.out : place.string();
  if (interrupted) say(stderr, "lcpbench: interrupted; {} holds the steps until then\n", printable(name));
  if (name != arguments.out) say(stderr, "lcpbench: {} is as it was\n", printable(arguments.out));
  say(stdout, "{} steps of {} by {} in {} ({} bytes)\n", count, arguments.scene, engine.name, printable(name),
      std::filesystem::file_size(place));
  const std::int64_t one = written.step_number(written.count() / 2);
  const std::string step = shell_word(file_argument(fmt::format("{}#{}", name, one)));
  say(stdout, "one of them in 3D: lcpbench view {0}\nits answers: lcpbench solve {0}\n", step);
  if (interrupted) return kExitInterrupted;
  return crashed ? kExitCheckFailed : kExitDone;
}

}  // namespace

std::string list_of_scenes() {
  std::string text = "\n\nScenes:";
  for (const capture::Scene& scene : capture::scenes()) text += fmt::format("\n  {:<20} {}", scene.name, scene.summary);
  return text;
}

Action add_capture_command(CLI::App& command) {
  const auto arguments = std::make_shared<CaptureArguments>();
  command.add_option("SCENE", arguments->scene, "scene; with --model, a name for what is captured")->required();
  command.add_option("--engine", arguments->engine,
                     "physics engine: ode, bullet, mujoco, dart, or a program of yours, external{command=...}");
  command.add_option("--model", arguments->model,
                     "model file of your own, in place of a scene, for MuJoCo: MJCF, or URDF with a ground and a "
                     "floating joint, which are two lines (see the page below)");
  add_number(command, "--every", arguments->every, "capture every so many steps",
             CLI::Range(INT64_C(1), INT64_C(1'000'000)));
  command.add_option("--steps", arguments->steps, "steps that the engine runs (default: the scene's own; 1,000 of a model)")
      ->check(CLI::Range(INT64_C(1), INT64_C(10'000'000)));
  command
      .add_option("--loop", arguments->loop,
                  "whose velocities move the scene on: engine, or one of lcpbench's own solvers, as auto")
      ->capture_default_str();
  command
      .add_option("--soft", arguments->soft,
                  "instead of hard contacts the softened ones that the engine itself solves, by its own solver as the "
                  "scene or model has it; exact: by 1,000 sweeps, or MuJoCo's newton at tolerance 0; newton, cg, pgs: "
                  "MuJoCo's")
      ->expected(0, 1)
      ->default_str("model")
      ->check(CLI::IsMember({"model", "newton", "cg", "pgs", "exact"}));
  command.add_option("--out", arguments->out, "file of captured steps (default: SCENE-ENGINE.scenes)");
  command.footer(
      "Scenes of free bodies run in ode (the default), bullet, mujoco, dart and external engines; scenes with joints "
      "in mujoco (the default), ode, bullet and dart; a motor not in mujoco. See docs/howto/capture-a-scene.md." +
      list_of_scenes());
  return [arguments] { return run_capture(*arguments); };
}

}  // namespace lcpbench
