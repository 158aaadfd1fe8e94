#include "study/replay/replay.h"

#include <algorithm>
#include <system_error>

#include "adapters/capture/launch.h"
#include "adapters/capture/scene.h"
#include "core/io/scenes_file.h"
#include "core/io/whole_file.h"
#include "core/registry.h"
#include "core/stepper.h"
#include "study/commands/commands.h"
#include "study/output/columns.h"
#include "study/replay/claims.h"
#include "study/replay/replay_folder.h"
#include "study/report/tables.h"
#include "study/report/text.h"
#include "study/run/open_solver.h"
#include "study/view/view.h"

namespace lcpbench {
namespace {

namespace fs = std::filesystem;
constexpr const char* kEngine = "engine";
constexpr std::int64_t kFrames = 31;  ///< of a film at most: the first step, the last one, and those between

struct ReplayArguments {
  std::vector<std::string> scenes;
  std::vector<std::string> solvers;
  std::vector<std::string> steppers;
  bool engine_solver = false;
  bool parting = false;
  std::string plan;                 ///< of claims; "": replay the scenes
  std::vector<std::string> claims;  ///< of the plan; none: all
  std::string model;                ///< of the user's robot; "": the scene's own bodies
  std::vector<std::string> stands;  ///< of the model, by name
  std::vector<std::pair<std::string, std::string>> grips;  ///< of the model: what is held, and by what
  std::string engine;               ///< "": that of the scene
  std::int64_t steps = 0;
  std::string out = "lcpbench-replay";
  bool fresh = false;
  bool json = false;
};

/// The one that was asked for, or the first that has what the scene needs.
std::string engine_for(const ReplayArguments& arguments, const capture::Scene& scene) {
  if (!arguments.engine.empty()) return arguments.engine;
  return arguments.model.empty() ? scene.engine() : "mujoco";
}

/// @throws InputError for a stepper with a solver that cannot step a scene on
void check_solver(const std::string& option, const Spec& stepper) {
  for (const auto& [key, value] : stepper.options) {
    if (key != "solver") continue;
    const std::string name = parse_spec(value).name;
    const RegisteredSolver& solver = find_solver(name);
    if (solver.definition.capabilities.captured_only) {
      throw InputError(fmt::format("{}: --engine-solver steps the scene with the engine's own solver", option));
    }
    if (const std::string reason = why_unavailable(solver); !reason.empty()) {
      throw InputError(fmt::format("solver '{}' is not available: {}", name, reason));
    }
  }
}

/// A way to take steps.
struct NamedStepper {
  std::string label;  ///< as the user spelled it
  std::string stepper;
};

/// Each once; then the engine's own solver, and the baseline at last. @throws InputError for those that cannot run
std::vector<NamedStepper> steppers_of(const ReplayArguments& arguments) {
  std::vector<NamedStepper> steppers;
  const auto add = [&](const char* option, const std::string& label, const Spec& spec) {
    const Spec stepper = canonical_stepper_spec(spec);
    check_solver(fmt::format("{} '{}'", option, label), stepper);
    const std::string text = stepper.text();
    const bool known = std::ranges::find(steppers, text, &NamedStepper::stepper) != steppers.end();
    if (!known) steppers.push_back({label, text});
  };
  for (const std::string& text : arguments.solvers) {
    add("--solver", text, {"exact", {{"solver", parse_spec(text).text()}}});
  }
  for (const std::string& text : arguments.steppers) add("--stepper", text, parse_spec(text));
  if (arguments.engine_solver) steppers.push_back({kEngine, kEngine});
  if (steppers.empty()) throw InputError("nothing to replay with: name a --stepper, a --solver, or --engine-solver");
  std::erase_if(steppers, [](const NamedStepper& each) { return each.stepper == kBaseline; });
  steppers.push_back({kBaseline, kBaseline});
  return steppers;
}

/// What one replay writes.
struct ReplayFiles {
  std::string frames;
  std::string track = frames + ".csv";
};

/// As the engine's program reads them, see read_marks() in adapters/capture/program.cpp.
std::string marks_text(const ReplayArguments& arguments) {
  std::string text;
  for (const std::string& name : arguments.stands) text += name + "\n";
  for (const auto& [held, by] : arguments.grips) text += held + "\t" + by + "\n";
  return text;
}

/// A name for each scene, model, engine, number of steps and stepper: the number tells steppers apart whose names are
/// alike as file names.
ReplayFiles files_of(const ReplayArguments& arguments, const std::string& engine, const std::string& scene,
                     std::int64_t steps, const std::string& stepper) {
  const Spec spec = capture::engine_spec(engine);
  std::uint32_t number = 2166136261;  // FNV-1a
  const std::string command = spec.options.empty() ? "" : spec.options.front().second;  // of an external engine
  for (const char c : stepper + arguments.model + command + marks_text(arguments)) number = (number ^ static_cast<unsigned char>(c)) * 16777619;
  const std::string name = fmt::format("{}-{}-{}-{}-{:08x}.scenes", report::file_stem(scene), spec.name, steps,
                                       report::file_stem(stepper).substr(0, 60), number);
  return {(fs::path(arguments.out) / "steps" / name).string()};
}

/// Steps the scene on, unless an earlier run did. @returns nullopt where it did not come to its end
std::optional<ReplayFiles> step_on(const ReplayArguments& arguments, const std::string& engine,
                                   const std::string& scene, std::int64_t steps, const std::string& stepper,
                                   const volatile std::sig_atomic_t* stop) {
  const ReplayFiles files = files_of(arguments, engine, scene, steps, stepper);
  std::error_code ignored;
  if (!arguments.fresh && is_complete_track(files.track) && fs::exists(files.frames, ignored)) return files;
  WholeFile frames(files.frames);
  WholeFile track(files.track);
  const std::int64_t every = (steps + kFrames - 2) / (kFrames - 1);
  const capture::EngineRun run =
      capture::run_engine(capture::engine_spec(engine),
                          {scene, arguments.model, std::to_string(every), std::to_string(steps),
                           frames.draft().string(), stepper, track.draft().string(), "", marks_text(arguments)},
                          stop);
  if (*stop != 0) return std::nullopt;
  if (run.ending == "exited with code 2") throw InputError(run.message);
  if (run.ending == "exited with code 0") {
    fs::remove(files.track, ignored);  // an old one never says that new frames are complete
    frames.commit();
    track.commit();
    if (run.message.starts_with("the problems differ")) {
      say(stderr, "lcpbench: {} with {}: {}: {}\n", scene, stepper, engine, run.message);
    }
    return files;
  }
  say(stderr, "lcpbench: {} with {}: {} {}{}\n", scene, stepper, engine, run.ending,
      run.message.empty() ? "" : ": " + run.message);
  return std::nullopt;
}

/// @param page  of the folder; it is written last
void write_results(const ReplayArguments& arguments, const std::vector<ReplayedFiles>& all, WholeFile& page) {
  const fs::path folder = arguments.out;
  std::vector<ReplayedScene> scenes;
  for (const ReplayedFiles& each : all) scenes.push_back(each.scene);
  write_file(folder / "summary.csv", replay_summary_csv(scenes));
  write_file(folder / "replays.json", replay_list(all));
  Json document{{"format", "lcpbench-report"}, {"version", 1}, {"kind", "view"}, {"scenes", Json::array()}};
  document["replays"] = Json::array();
  for (const ReplayedFiles& each : all) document["replays"].push_back(replay_view(each));
  page.write(report::page_html(document));
  page.commit();
}

/// The spec of the same scene with its first body 1e-12 m aside along x and along y.
std::string with_nudge(const std::string& scene) {
  Spec spec = parse_spec(scene);
  spec.options.emplace_back("nudge", "1e-12");
  return spec.text();
}

/// Replays a scene with every stepper. @returns whether all came to their end
bool replay_scene(const ReplayArguments& arguments, const capture::Scene& scene,
                  const std::vector<NamedStepper>& steppers, const volatile std::sig_atomic_t* stop,
                  ProgressLine& progress, std::vector<ReplayedFiles>& all) {
  ReplayedFiles result;
  result.scene.scene = scene.name;
  result.scene.steps = arguments.steps > 0 ? arguments.steps : scene.steps;
  result.scene.pushed = std::any_of(scene.bodies.begin(), scene.bodies.end(),
                                    [](const capture::Body& body) { return !body.push.force.isZero(0); });
  const std::string engine = engine_for(arguments, scene);
  bool complete = true;
  for (const auto& [label, stepper] : steppers) {
    if (*stop != 0) return false;
    progress.show(fmt::format("{} with {}", scene.name, label));
    const auto files = step_on(arguments, engine, scene.name, result.scene.steps, stepper, stop);
    complete = complete && files;
    if (!files) continue;
    result.scene.replays.push_back(read_track(files->track, label));
    result.scene.replays.back().stepper = stepper;
    result.scene.replays.back().may_drift = !arguments.model.empty() && arguments.stands.empty();
    result.frames.push_back(std::make_unique<ScenesFile>(files->frames));
    result.names.push_back(fs::path(files->frames).filename().string());
    result.scene.engine = result.frames.back()->header().engine;
    result.scene.step_length_s = result.frames.back()->header().step_length.value_or(scene.step);
    if (!arguments.parting) continue;
    const auto beside = step_on(arguments, engine, with_nudge(scene.name), result.scene.steps, stepper, stop);
    complete = complete && beside;
    if (beside) result.scene.replays.back().parts_s = parting_s(*result.frames.back(), ScenesFile(beside->frames));
  }
  if (!result.frames.empty() && *stop == 0) all.push_back(std::move(result));
  return complete;
}

/// @param scene  of the document
void print_scene(const Json& scene) {
  using Align = TextTable::Align;
  const auto metres = [](double value) { return length_text(value); };
  const auto joules = [](double value) { return fmt::format("{:.2g} J", value); };
  const std::vector<JsonColumn> columns{{{"stepper", Align::kLeft}, field("solver")},
                                        {{"steps"}, field("survived")},
                                        {{"drift"}, field("drift_m", metres)},
                                        {{"slip"}, field("slip_m", metres)},
                                        {{"deepest"}, field("deepest_m", metres)},
                                        {{"energy rise", Align::kRight, 1}, field("energy_rise_j", joules)},
                                        {{"time for 1 s", Align::kRight, 2}, field("cpu_s_per_s", format_seconds)},
                                        {{"parts after", Align::kRight, 3}, field("parts_s", format_seconds)},
                                        {{"impulses", Align::kLeft, 4}, field("impulses")}};
  say_folded("{}:\n", scene["conclusion"].get<std::string>());
  say(stdout, "{}", table_text(columns, scene["replays"]));
  for (const Json& replay : scene["replays"]) {
    const auto end = replay["end"].get<std::string>();
    if (!end.empty()) say_folded("{}: {}\n", replay["solver"].get<std::string>(), end);
  }
  say(stdout, "\n");
}

constexpr const char* kBuiltinClaims = "claims-of-the-field";

/// @throws InputError for steppers that cannot step a scene: it would count as lost
void check_steppers(const FieldClaim& claim) {
  for (const std::string& text : claim.steppers) {
    const Spec stepper = canonical_stepper_spec(parse_spec(text));
    check_solver(fmt::format("claim '{}'", claim.id), stepper);
    for (const std::string& scene : claim.scenes) {
      if (!capture::find_scene(scene).articulated() || !find_stepper(stepper.name).bodies_only) continue;
      throw InputError(fmt::format("claim '{}': {} knows free bodies only; '{}' has joints", claim.id, text, scene));
    }
  }
}

/// Those that were asked for. @throws InputError
std::vector<FieldClaim> claims_of(const ReplayArguments& arguments) {
  if (!arguments.scenes.empty()) throw InputError("--plan: has its own scenes; leave SCENE out");
  const bool built_in = arguments.plan == kBuiltinClaims;
  const std::string text = built_in ? std::string(kClaimsOfTheField) : read_text(arguments.plan, "plan of claims");
  std::vector<FieldClaim> claims = read_claims(text, arguments.plan);
  if (arguments.claims.empty()) return claims;
  std::vector<FieldClaim> wanted;
  for (const std::string& id : arguments.claims) {
    const auto found = std::ranges::find(claims, id, &FieldClaim::id);
    if (found == claims.end()) throw InputError(fmt::format("--claim '{}': is none of {}", id, arguments.plan));
    wanted.push_back(*found);
  }
  return wanted;
}

/// Replays a scene of a claim with all that it compares, with each repetition. @returns whether all came to their end
bool measure_claim(const ReplayArguments& arguments, const FieldClaim& claim, const volatile std::sig_atomic_t* stop,
                   ProgressLine& progress, ClaimedScene& measured) {
  std::vector<NamedStepper> steppers;
  for (const std::string& text : claim.steppers) {
    const Spec spec = parse_spec(text);
    steppers.push_back({stepper_label(spec), canonical_stepper_spec(spec).text()});
  }
  steppers.push_back({kBaseline, kBaseline});
  measured.values.resize(steppers.size());
  for (const double nudge : kClaimNudges) {
    const auto replayed = [&](std::int64_t divide, const std::vector<NamedStepper>& with) {
      ReplayArguments one = arguments;
      one.engine = claim.engine;
      one.steps = kClaimSteps * divide;
      const Spec scene{measured.scene, {{"divide", std::to_string(divide)}, {"nudge", format_real(nudge)}}};
      std::vector<ReplayedFiles> all;
      const bool complete = replay_scene(one, capture::find_scene(scene.text()), with, stop, progress, all);
      return complete && all.size() == 1 ? std::move(all.front()) : ReplayedFiles{};
    };
    const ReplayedFiles files = replayed(1, steppers);
    if (files.frames.size() != steppers.size()) return false;
    const bool needs_truth = claim.measure == "error_m";
    const ReplayedFiles truth = needs_truth ? replayed(kTruthDivide, {{"truth", kTruthStepper}}) : ReplayedFiles{};
    if (needs_truth && truth.frames.empty()) return false;
    for (std::size_t i = 0; i < steppers.size(); ++i) {
      measured.values[i].push_back(needs_truth ? error_of(*files.frames[i], *truth.frames[0])
                                               : measure_of(files.scene.replays[i], kClaimSteps, claim.measure));
    }
  }
  return true;
}

int interrupted(const ProgressLine& progress) {
  progress.clear();
  say(stderr, "lcpbench: interrupted; the same command without --fresh keeps what is finished\n");
  return kExitInterrupted;
}

int run_claims(const ReplayArguments& arguments) {
  const std::vector<FieldClaim> claims = claims_of(arguments);
  for (const FieldClaim& claim : claims) check_steppers(claim);
  make_folder(fs::path(arguments.out) / "steps");
  const volatile std::sig_atomic_t* stop = catch_interrupts(kExitInterrupted);
  WholeFile page(fs::path(arguments.out) / "claims.md");
  ProgressLine progress;
  std::string sections;
  std::string verdicts;
  std::string lines;
  bool complete = true;
  for (const FieldClaim& claim : claims) {
    std::vector<ClaimedScene> scenes;
    for (const std::string& scene : claim.scenes) {
      ClaimedScene measured{scene, {}};
      const bool all_ended = measure_claim(arguments, claim, stop, progress, measured);
      if (*stop != 0) return interrupted(progress);
      complete = complete && all_ended;
      if (all_ended) scenes.push_back(std::move(measured));
    }
    if (scenes.empty()) continue;
    sections += "\n" + claim_section(claim, scenes);
    verdicts += fmt::format("| [{}](#{}) | {} |\n", claim.claim, claim.id, claim_verdict(claim, scenes));
    lines += fmt::format("{}: {}\n", claim.id, claim_verdict(claim, scenes));
  }
  progress.clear();
  page.write(claims_page(arguments.plan, verdicts, sections));
  page.commit();
  say(stdout, "{}claims and numbers: {}\n", lines, printable((fs::path(arguments.out) / "claims.md").string()));
  return complete ? kExitDone : kExitCheckFailed;
}

int run_replay(const ReplayArguments& arguments) {
  if (!arguments.plan.empty()) return run_claims(arguments);
  if (arguments.scenes.empty()) throw InputError("SCENE: name a scene, or a --plan");
  if (!arguments.model.empty() && !fs::is_regular_file(arguments.model)) {
    throw InputError(fmt::format("--model '{}': no such file", arguments.model));
  }
  std::vector<capture::Scene> scenes;
  for (const std::string& name : arguments.scenes) {
    capture::Scene scene;
    scene.name = name;
    if (arguments.model.empty()) scene = capture::find_scene(name);
    if (arguments.parting) capture::find_scene(with_nudge(scene.name));  // refuses what cannot be nudged
    const bool known = std::ranges::find(scenes, scene.name, &capture::Scene::name) != scenes.end();
    if (!known) scenes.push_back(std::move(scene));
  }
  const std::vector<NamedStepper> steppers = steppers_of(arguments);
  if (!arguments.engine.empty()) capture::engine_spec(arguments.engine);  // refuses what is none, and makes no folder
  make_folder(fs::path(arguments.out) / "steps");
  const volatile std::sig_atomic_t* stop = catch_interrupts(kExitInterrupted);
  WholeFile page(fs::path(arguments.out) / "index.html");  // its lock keeps another replay out of the folder
  ProgressLine progress;
  std::vector<ReplayedFiles> all;
  bool complete = true;
  for (const capture::Scene& scene : scenes) {
    complete = replay_scene(arguments, scene, steppers, stop, progress, all) && complete;
    if (*stop != 0) break;
  }
  if (*stop != 0) return interrupted(progress);
  progress.clear();
  write_results(arguments, all, page);
  Json rows = Json::array();
  for (const ReplayedFiles& each : all) rows.push_back(replay_json(each.scene));
  if (arguments.json) {
    print_json(rows);
  } else {
    for (const Json& scene : rows) print_scene(scene);
    say(stdout, "films and curves: {}\n", printable((fs::path(arguments.out) / "index.html").string()));
  }
  return complete ? kExitDone : kExitCheckFailed;
}

}  // namespace

Action add_replay_command(CLI::App& command) {
  const auto arguments = std::make_shared<ReplayArguments>();
  command.add_option("SCENE", arguments->scenes,
                     "scenes, as `lcpbench capture --help` lists them; stack{divide=4} has four times as many steps");
  add_repeatable(command, "--solver", arguments->solvers, "short for --stepper exact{solver=...}; may be repeated");
  add_repeatable(command, "--stepper", arguments->steppers, "name{key=value,...}; may be repeated");
  command.add_flag("--engine-solver", arguments->engine_solver, "also step on as the engine does by itself");
  command.add_flag("--parting", arguments->parting,
                   "step each a second time with the first body 1e-12 m aside in x and y: parts_s tells when they part");
  command
      .add_option("--model", arguments->model,
                  "model file of your own, as of `capture --model`; SCENE is then a name for it")
      ->excludes("--parting");
  add_repeatable(command, "--stands", arguments->stands,
                 "body, geometry or site of the model that should stay where it begins: its drift is measured (default: "
                 "that of every free body, which loses no scene)")
      ->needs("--model");
  command
      .add_option("--grip", arguments->grips,
                  "two of them, of which the second holds the first: its slip is measured; may be repeated")
      ->type_name("HELD BY")
      ->needs("--model");
  command
      .add_option("--engine", arguments->engine,
                  "whose collision detection and integrator: ode, bullet, mujoco, dart or external{command=...} "
                  "(default: ode; mujoco for scenes with joints)");
  command.add_option("--steps", arguments->steps, "steps of each replay (default: the scene's own)")
      ->check(CLI::Range(INT64_C(1), INT64_C(1'000'000)));
  CLI::Option* plan = command.add_option("--plan", arguments->plan,
                                         "test what the field says: claims-of-the-field, or a file of such claims");
  // A plan names its steppers and engines, and all plans have the same steps: nothing that was asked for is left out.
  for (const char* each : {"--solver", "--stepper", "--engine-solver", "--parting", "--model", "--engine", "--steps"}) {
    plan->excludes(each);
  }
  add_repeatable(command, "--claim", arguments->claims, "only this claim of the plan; may be repeated")->needs(plan);
  command.add_option("--out", arguments->out, "folder of the page, the tables and the steps")->capture_default_str();
  command.add_flag("--fresh", arguments->fresh, "replay anew what the folder has already");
  add_output_options(command, arguments->json);
  command.footer(
      "The scene is stepped on in each way: the same integrator, the same collision detection. `lcpbench steppers` "
      "lists the ways. Each starts from its last answer, by contact. The step without any contact, `nothing`, stands "
      "beside them. Ctrl-C ends with exit code 3; the same command goes on. Exit code 1: an engine crashed. See "
      "docs/howto/replay-a-scene.md." +
      list_of_scenes());
  return [arguments] { return run_replay(*arguments); };
}

}  // namespace lcpbench
