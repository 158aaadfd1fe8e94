#include "study/view/view.h"

#include <algorithm>

#include "core/io/problem_io.h"
#include "core/io/scenes_file.h"
#include "core/io/whole_file.h"
#include "study/certificates/judge.h"
#include "study/commands/commands.h"
#include "study/commands/problem_files.h"
#include "study/output/columns.h"
#include "study/replay/replay_folder.h"
#include "study/report/tables.h"
#include "study/run/open_solver.h"
#include "study/run/study.h"

namespace lcpbench {
namespace {

namespace fs = std::filesystem;
/// Beside the reference the engine's own answer, or projected Gauss-Seidel with as few sweeps as engines make.
std::vector<std::string> default_solvers(const Problem& problem) {
  if (problem.engine_impulses() != nullptr) return {"engine", "auto"};
  return {"auto", "psor{max_iterations=20}"};
}

struct ViewArguments {
  std::string file;
  std::vector<std::string> solvers;  ///< none: default_solvers()
  double time_limit_s = 10.0;
  std::string out = "view.html";
  bool json = false;
};

/// A step, or a problem file as one.
struct Shown {
  ScenesHeader header;
  SceneStep step;
};

Shown read_shown(const std::string& file) {
  Shown shown;
  if (const auto named = named_step(file)) {
    if (!named->scenes->truncation().empty()) say(stderr, "lcpbench: {}\n", printable(named->scenes->truncation()));
    shown.header = named->scenes->header();
    shown.step = named->read();
  } else if (is_scenes_file(file)) {
    const ScenesFile scenes(file);
    throw InputError(scenes.count() == 0 ? fmt::format("{}: has no steps", file)
                                         : fmt::format("{}: holds {} steps; name one, as '{}#{}'", file,
                                                       scenes.count(), file, scenes.step_number(0)));
  } else {
    shown.step.problem = read_named_problem(file);
  }
  if (shown.step.problem.contact() == nullptr) {
    throw InputError(fmt::format("{}: is a bare LCP, which has no bodies and no contacts", file));
  }
  return shown;
}

/// In canonical form, each once. @throws InputError for names and settings that are none
std::vector<Spec> chosen(const std::vector<std::string>& texts) {
  std::vector<Spec> solvers;
  for (const Spec& spec : solver_specs(texts)) {
    if (std::ranges::find(solvers, spec.text(), &Spec::text) == solvers.end()) solvers.push_back(spec);
  }
  return solvers;
}

std::vector<ViewedAnswer> answers_to(const Problem& problem, const std::vector<Spec>& solvers,
                                     const std::string& engine, double time_limit_s,
                                     const volatile std::sig_atomic_t* stop) {
  BoundedCertifier certifier;
  Judge judge(problem, certifier);
  const TimedRequest request{.time_limit_s = time_limit_s,
                             .repeat_until_s = are_timed_once(solvers) ? 0 : kRepeatUntilS};
  std::vector<ViewedAnswer> answers;
  for (const Spec& spec : solvers) {
    if (*stop != 0) break;
    TimedAnswer timed;
    open_solver(spec)->run(problem, request, timed);
    const FrictionModel model = friction_model(solver_row(spec).friction, problem);
    answers.push_back({.solver = solver_label(spec.text(), engine),
                       .model = model,
                       .claim = timed.answer.claim,
                       .errors = judge.judgement(judge.judge(timed.answer, model)).errors,
                       .time_s = timed.times.setup_cpu_s + timed.times.solve_cpu_s,
                       .z = timed.answer.z});
  }
  for (ViewedAnswer& answer : answers) {
    const bool pyramid = answer.model == FrictionModel::kPyramid;
    answer.verdict = verdict(answer.claim, answer.errors, pyramid ? judge.findings().truth() : Truth::kUnknown);
  }
  return answers;
}

Json step_document(const ViewArguments& arguments, const volatile std::sig_atomic_t* stop) {
  const Shown shown = interruptibly([&] { return read_shown(arguments.file); });
  const Problem& problem = shown.step.problem;
  std::vector<Spec> solvers = chosen(arguments.solvers.empty() ? default_solvers(problem) : arguments.solvers);
  for (Spec& spec : solvers) spec = judged_as_solved(spec, problem, arguments.file);
  const std::vector<ViewedAnswer> answers =
      answers_to(problem, solvers, shown.header.engine_label(), arguments.time_limit_s, stop);
  return step_view(shown.header, shown.step, arguments.file, answers);
}

Json replays_of(const ViewArguments& arguments) {
  if (!arguments.solvers.empty()) {
    throw InputError(fmt::format("--solver: '{}' is a folder of replays, which has its solvers", arguments.file));
  }
  Json views = Json::array();
  interruptibly([&] {
    for (const ReplayedFiles& replays : read_replays(arguments.file)) views.push_back(replay_view(replays));
  });
  return views;
}

/// A line for each answer.
std::string in_words(const Json& step) {
  std::string text = step["title"].get<std::string>() + "\n";
  for (const Json& answer : step["answers"]) {
    const Json& error = answer["error_m_per_s"];
    text += fmt::format("  {}: claim {}, verdict {}{}\n", answer["solver"].get<std::string>(),
                        answer["claim"].get<std::string>(), answer["verdict"].get<std::string>(),
                        error.is_null() ? "" : fmt::format(", error {:.1e} m/s", error.get<double>()));
  }
  return text;
}

int view(const ViewArguments& arguments) {
  const volatile std::sig_atomic_t* stop = catch_interrupts(kExitInterrupted);
  std::error_code ignored;
  const bool folder = fs::is_directory(arguments.file, ignored);
  Json document{{"format", "lcpbench-report"}, {"version", 1}, {"kind", "view"}};
  document["scenes"] = folder ? Json::array() : Json::array({step_document(arguments, stop)});
  document["replays"] = folder ? replays_of(arguments) : Json::array();
  if (*stop != 0) return kExitInterrupted;
  if (arguments.json) {
    print_json(document);
  } else {
    write_file(arguments.out, report::page_html(document));
    for (const Json& step : document["scenes"]) say_folded("{}", in_words(step));
    say(stdout, "page: {}\n", printable(arguments.out));
  }
  const auto crashed = [](const Json& answer) { return answer["claim"] == to_string(Claim::kCrashed); };
  for (const Json& step : document["scenes"]) {
    if (std::any_of(step["answers"].begin(), step["answers"].end(), crashed)) return kExitCheckFailed;
  }
  return kExitDone;
}

}  // namespace

Action add_view_command(CLI::App& command) {
  const auto arguments = std::make_shared<ViewArguments>();
  command.add_option("FILE", arguments->file, "a step F.scenes#K or problem SET#K, a problem file, or the folder of `lcpbench replay`")
      ->required();
  add_repeatable(command, "--solver", arguments->solvers,
                 "name{key=value,...}; may be repeated (default: auto, beside the engine's own answer, else psor{max_iterations=20})");
  add_number(command, "--time-limit", arguments->time_limit_s, "seconds for each solve", number_check());
  command.add_option("--out", arguments->out, "file of the page")->capture_default_str();
  add_output_options(command, arguments->json);
  command.footer(
      "The page needs nothing else: bodies, contacts, impulses and velocities, the answers of two solvers side by "
      "side, coloured by the error at each contact; replays as films. --format json prints what the page shows, and "
      "writes no page. Exit code 1: a solver crashed. See docs/howto/report-a-failing-case.md.");
  return [arguments] { return view(*arguments); };
}

}  // namespace lcpbench
