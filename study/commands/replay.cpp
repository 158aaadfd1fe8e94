#include "study/replay/replay.h"

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "adapters/capture/launch.h"
#include "adapters/capture/scene.h"
#include "core/error.h"
#include "core/io/whole_file.h"
#include "core/io/scenes_file.h"
#include "core/registry.h"
#include "core/suggestion.h"
#include "study/commands/commands.h"
#include "study/commands/options.h"
#include "study/output/json_output.h"
#include "study/output/terminal.h"
#include "study/output/text_table.h"
#include "study/replay/replay_folder.h"
#include "study/report/page.h"
#include "study/report/text.h"
#include "study/run/interrupt.h"
#include "study/run/open_solver.h"
#include "study/view/view.h"

namespace lcpbench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kEngine = "engine";
constexpr std::int64_t kFrames = 31;  ///< of a film at most: the first step, the last one, and those between

struct ReplayArguments {
  std::vector<std::string> scenes;
  std::vector<std::string> solvers;
  bool engine_solver = false;
  std::string engine;  ///< "": that of the scene
  std::int64_t steps = 0;
  std::string out;
  bool fresh = false;
  std::string format = "text";
};

const capture::Scene& find_scene(const std::string& name) {
  std::vector<std::string> names;
  for (const capture::Scene& scene : capture::scenes()) {
    names.push_back(scene.name);
    if (scene.name == name) return scene;
  }
  throw InputError(
      fmt::format("unknown scene '{}'{}; `lcpbench replay --help` lists them", name, did_you_mean(name, names)));
}

/// The one that was asked for, or the first that has what the scene needs.
std::string engine_for(const ReplayArguments& arguments, const capture::Scene& scene) {
  if (!arguments.engine.empty()) return arguments.engine;
  return scene.articulated() ? "mujoco" : "ode";
}

/// In canonical form, each once; the engine's own solver last. @throws InputError for those that cannot run
std::vector<std::string> solvers_of(const ReplayArguments& arguments) {
  std::vector<std::string> solvers;
  for (const std::string& text : arguments.solvers) {
    const Spec spec = canonical_solver_spec(parse_spec(text));
    const RegisteredSolver& solver = find_solver(spec.name);
    if (solver.definition.capabilities.captured_only) {
      throw InputError(
          fmt::format("--solver '{}': --engine-solver steps the scene with the engine's own solver", text));
    }
    if (const std::string reason = why_unavailable(solver); !reason.empty()) {
      throw InputError(fmt::format("solver '{}' is not available: {}", spec.name, reason));
    }
    if (std::find(solvers.begin(), solvers.end(), spec.text()) == solvers.end()) solvers.push_back(spec.text());
  }
  if (arguments.engine_solver) solvers.emplace_back(kEngine);
  if (solvers.empty()) throw InputError("nothing to replay with: name a --solver, or --engine-solver");
  return solvers;
}

/// What one replay writes.
struct ReplayFiles {
  std::string frames;
  std::string track = frames + ".csv";
};

/// A name for each scene, engine, number of steps and solver: the number tells solvers apart whose names are alike as
/// file names.
ReplayFiles files_of(const ReplayArguments& arguments, const std::string& engine, const std::string& scene,
                     std::int64_t steps, const std::string& solver) {
  std::uint32_t number = 2166136261;  // FNV-1a
  for (const char c : solver) number = (number ^ static_cast<unsigned char>(c)) * 16777619;
  const std::string name =
      fmt::format("{}-{}-{}-{}-{:08x}.scenes", scene, engine, steps, report::file_stem(solver).substr(0, 60), number);
  return {(fs::path(arguments.out) / "steps" / name).string()};
}

/// Steps the scene on with the solver, unless an earlier run did. @returns whether it came to its end
bool step_on(const ReplayArguments& arguments, const std::string& engine, const std::string& scene, std::int64_t steps,
             const std::string& solver, const ReplayFiles& files, const volatile std::sig_atomic_t* stop) {
  std::error_code ignored;
  if (!arguments.fresh && is_complete_track(files.track) && fs::exists(files.frames, ignored)) return true;
  WholeFile frames(files.frames);
  WholeFile track(files.track);
  const std::int64_t every = (steps + kFrames - 2) / (kFrames - 1);
  const capture::EngineRun run =
      capture::run_engine(engine,
                          {scene, "", std::to_string(every), std::to_string(steps), frames.draft().string(), solver,
                           track.draft().string(), ""},
                          stop);
  if (*stop != 0) return false;
  if (run.ending == "exited with code 2") throw InputError(run.message);
  if (run.ending == "exited with code 0") {
    fs::remove(files.track, ignored);  // an old one never says that new frames are complete
    frames.commit();
    track.commit();
    return true;
  }
  say(stderr, "lcpbench: {} with {}: {} {}{}\n", scene, solver, engine, run.ending,
      run.message.empty() ? "" : ": " + run.message);
  return false;
}

void make_folder(const ReplayArguments& arguments) {
  std::error_code error;
  fs::create_directories(fs::path(arguments.out) / "steps", error);
  if (error) throw InputError(fmt::format("--out '{}': {}", arguments.out, error.message()));
}

/// @param page  of the folder; it is written last
void write_results(const ReplayArguments& arguments, const std::vector<ReplayedFiles>& all, WholeFile& page) {
  const fs::path folder = arguments.out;
  std::vector<ReplayedScene> scenes;
  std::string conclusions;
  for (const ReplayedFiles& each : all) {
    scenes.push_back(each.scene);
    conclusions += "- " + conclusion(each.scene) + "\n";
    write_file(folder / (each.scene.scene + ".csv"), replay_steps_csv(each.scene));
  }
  write_file(folder / "summary.csv", replay_summary_csv(scenes));
  write_file(folder / "conclusions.md", conclusions);
  write_file(folder / "replays.json", replay_list(all));
  Json document{{"format", "lcpbench-report"}, {"version", 1}, {"kind", "view"}, {"scenes", Json::array()}};
  document["replays"] = Json::array();
  for (const ReplayedFiles& each : all) document["replays"].push_back(replay_view(each));
  page.write(report::page_html(document));
  page.commit();
}

/// Replays a scene with every solver. @returns whether all came to their end
bool replay_scene(const ReplayArguments& arguments, const capture::Scene& scene,
                  const std::vector<std::string>& solvers, const volatile std::sig_atomic_t* stop,
                  ProgressLine& progress, std::vector<ReplayedFiles>& all) {
  ReplayedFiles result;
  result.scene.scene = scene.name;
  result.scene.steps = arguments.steps > 0 ? arguments.steps : scene.steps;
  result.scene.pushed = std::any_of(scene.bodies.begin(), scene.bodies.end(),
                                    [](const capture::Body& body) { return !body.push.force.isZero(0); });
  const std::string engine = engine_for(arguments, scene);
  bool complete = true;
  for (const std::string& solver : solvers) {
    if (*stop != 0) return false;
    progress.show(fmt::format("{} with {}", scene.name, solver));
    const ReplayFiles files = files_of(arguments, engine, scene.name, result.scene.steps, solver);
    if (!step_on(arguments, engine, scene.name, result.scene.steps, solver, files, stop)) {
      complete = false;
      continue;
    }
    result.scene.replays.push_back(read_track(files.track, solver));
    result.frames.push_back(std::make_unique<ScenesFile>(files.frames));
    result.names.push_back(fs::path(files.frames).filename().string());
    result.scene.engine = result.frames.back()->header().engine;
    result.scene.step_length_s = result.frames.back()->header().step_length.value_or(scene.step);
  }
  if (!result.frames.empty() && *stop == 0) all.push_back(std::move(result));
  return complete;
}

int run_replay(const ReplayArguments& arguments) {
  std::vector<const capture::Scene*> scenes;
  for (const std::string& name : arguments.scenes) {
    const capture::Scene* const scene = &find_scene(name);
    if (std::find(scenes.begin(), scenes.end(), scene) == scenes.end()) scenes.push_back(scene);
  }
  const std::vector<std::string> solvers = solvers_of(arguments);
  make_folder(arguments);
  const volatile std::sig_atomic_t* stop = catch_interrupts(kExitInterrupted);
  WholeFile page(fs::path(arguments.out) / "index.html");  // its lock keeps another replay out of the folder
  ProgressLine progress;
  std::vector<ReplayedFiles> all;
  bool complete = true;
  for (const capture::Scene* scene : scenes) {
    complete = replay_scene(arguments, *scene, solvers, stop, progress, all) && complete;
    if (*stop != 0) break;
  }
  progress.clear();
  if (*stop != 0) {
    say(stderr, "lcpbench: interrupted; the same command goes on where it stopped\n");
    return kExitInterrupted;
  }
  write_results(arguments, all, page);
  if (arguments.format == "json") {
    Json rows = Json::array();
    for (const ReplayedFiles& each : all) rows.push_back(replay_json(each.scene));
    print_json(rows);
  } else {
    for (const ReplayedFiles& each : all) say(stdout, "{}", folded(conclusion(each.scene) + "\n", terminal_width()));
    say(stdout, "films and curves: {}\n", printable((fs::path(arguments.out) / "index.html").string()));
  }
  return complete ? kExitDone : kExitCheckFailed;
}

std::string list_of_scenes() {
  std::string text =
      "The scene is stepped on with each solver's answers, whatever their verdicts: the same integrator, the same "
      "collision detection. Each solve is from a cold start, which no engine does but ODE and DART: from the impulses "
      "of the step before, a solver of few sweeps may keep a scene that it loses here. Ctrl-C ends with exit code 3; "
      "the same command goes on. Exit code 1: an engine crashed. See docs/howto/replay-a-scene.md.\n\nScenes:";
  for (const capture::Scene& scene : capture::scenes()) {
    text += fmt::format("\n  {:<20} {}", scene.name, scene.summary);
  }
  return text;
}

}  // namespace

Action add_replay_command(CLI::App& command) {
  const auto arguments = std::make_shared<ReplayArguments>();
  command.add_option("SCENE", arguments->scenes, "scenes, as `lcpbench capture --help` lists them")->required();
  command.add_option("--solver", arguments->solvers, "name{key=value,...}; may be repeated")->allow_extra_args(false);
  command.add_flag("--engine-solver", arguments->engine_solver, "also step on as the engine does by itself");
  command
      .add_option("--engine", arguments->engine,
                  "whose collision detection and integrator: ode, bullet, mujoco or dart (default: ode; mujoco for "
                  "scenes with joints, which mujoco and dart step)")
      ->check(CLI::IsMember({"ode", "bullet", "mujoco", "dart"}));
  command.add_option("--steps", arguments->steps, "steps of each replay (default: the scene's own)")
      ->check(CLI::Range(INT64_C(1), INT64_C(1'000'000)));
  command.add_option("--out", arguments->out, "folder of the page, the tables and the steps")->required();
  command.add_flag("--fresh", arguments->fresh, "replay anew what the folder has already");
  add_format_option(command, arguments->format);
  command.footer(list_of_scenes());
  return [arguments] { return run_replay(*arguments); };
}

}  // namespace lcpbench
