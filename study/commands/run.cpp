#include <algorithm>
#include <cmath>
#include <regex>

#include <unistd.h>

#include "core/io/scenes_file.h"
#include "core/registry.h"
#include "generators/sets.h"
#include "study/commands/commands.h"
#include "study/commands/problem_files.h"
#include "study/commands/stores.h"
#include "study/report/report.h"
#include "study/report/text.h"
#include "study/report/worst.h"
#include "study/run/build_info.h"
#include "study/run/open_solver.h"
#include "study/run/plan.h"
#include "study/run/provenance.h"
#include "study/run/runner.h"
#include "study/run/shards.h"

namespace lcpbench {
namespace {

constexpr const char* kDefaultPlan = "quick";
constexpr const char* kAdHocPlan = "custom";

struct RunArguments {
  std::string plan;
  std::vector<std::string> sets;
  std::vector<std::string> solvers;
  std::string sweep;
  std::optional<std::int64_t> trials;
  std::optional<std::uint64_t> seed;
  std::optional<int> jobs;
  std::optional<double> budget_s;
  std::optional<double> solved_at;
  std::string store;
  std::string shard;
  std::optional<std::int64_t> list_shards;
  std::string costs;
  std::string start;
  bool fresh = false;
  bool all = false;
  bool json = false;
};

/// @param text  "I/N"; "" for all
void set_shard(const std::string& text, RunOptions& options) {
  if (text.empty()) return;
  std::smatch numbers;
  if (std::regex_match(text, numbers, std::regex("(\\d{1,9})/(\\d{1,9})"))) {
    options.shard = std::stoll(numbers[1]) - 1;
    options.shards = std::stoll(numbers[2]);
    if (options.shard >= 0 && options.shard < options.shards) return;
  }
  throw InputError("--shard " + text + ": expected I/N with 1 <= I <= N");
}

/// Has one of the sets that the pattern names captured steps?
bool has_captured_steps(const std::string& pattern) {
  const std::vector<std::string> sets = expand_sets(pattern);
  return std::any_of(sets.begin(), sets.end(), [](const std::string& set) {
    return set.starts_with("scene/") || (set.starts_with("file:") && (is_scenes_file(set) || scenes_step(set)));
  });
}

/// Every solver that needs no setting from the user. Unavailable solvers are listed as skipped. The solver `engine`,
/// which repeats the answer of the capturing engine, is added if a set has captured steps.
std::vector<PlannedSolver> every_solver(const std::vector<std::string>& sets) {
  const bool captured = std::any_of(sets.begin(), sets.end(), has_captured_steps);
  std::vector<PlannedSolver> solvers;
  for (const RegisteredSolver& solver : registered_solvers()) {
    if (needs_to_be_told(solver) || (solver.definition.capabilities.captured_only && !captured)) continue;
    solvers.push_back({.spec = {solver.definition.name, {}}, .optional = true});
  }
  return solvers;
}

Plan base_plan(const RunArguments& arguments) {
  if (!arguments.plan.empty()) return load_plan(arguments.plan);
  if (arguments.sets.empty()) return load_plan(kDefaultPlan);
  Plan plan;
  plan.name = kAdHocPlan;
  plan.solvers = every_solver(arguments.sets);
  return plan;
}

/// Lays the sweep over the solvers. Those that were not asked for by name and have no such grid are left out.
void apply_sweep(const RunArguments& arguments, Plan& plan) {
  if (arguments.solvers.empty()) {
    std::erase_if(plan.solvers, [&](const PlannedSolver& solver) {
      return solver.sweep || !has_builtin_sweep(arguments.sweep, solver.spec);
    });
  }
  for (PlannedSolver& solver : plan.solvers) solver.sweep = builtin_sweep(arguments.sweep, solver.spec);
  if (plan.solvers.empty()) throw InputError("--sweep " + arguments.sweep + ": no solver of the plan has such a sweep");
}

/// The solver `engine` by the friction that the engine solves, if that is the same in all sets: see judged_as_solved.
void judge_engine_as_solved(Plan& plan) {
  static constexpr std::size_t kLookedAt = 100;  // steps: the first ones may have no contacts with friction
  const auto in_set = [](const Spec& spec, const PlannedSet& set) {
    if (!set.pattern.starts_with("file:") || !is_scenes_file(set.pattern)) return spec;
    const std::string file = set.pattern.substr(std::string_view("file:").size());
    const ScenesFile scenes(file);
    Spec judged = spec;
    for (std::size_t i = 0; i < std::min(scenes.count(), kLookedAt) && judged.options == spec.options; ++i) {
      judged = judged_as_solved(spec, scenes.read(i).problem, fmt::format("{}#{}", file, scenes.step_number(i)));
    }
    return judged;
  };
  for (PlannedSolver& solver : plan.solvers) {
    if (solver.spec.name != "engine" || plan.sets.empty()) continue;
    const Spec judged = in_set(solver.spec, plan.sets.front());
    const bool alike = std::ranges::all_of(plan.sets, [&](const PlannedSet& set) {
      return in_set(solver.spec, set).options == judged.options;
    });
    if (alike) solver.spec = judged;
  }
}

/// The plan with what the command line says instead.
Plan make_plan(const RunArguments& arguments) {
  Plan plan = base_plan(arguments);
  if (!arguments.sets.empty()) {
    plan.sets.clear();
    for (const std::string& set : arguments.sets) {
      plan.sets.push_back({.pattern = set});
      if (set.starts_with("file:")) plan.sets.back().trials = kMaxTrials;
    }
    plan.other_sets = true;
  }
  if (!arguments.solvers.empty()) {
    plan.solvers.clear();
    for (const Spec& spec : solver_specs(arguments.solvers)) plan.solvers.push_back({.spec = spec});
  }
  if (!arguments.sweep.empty()) apply_sweep(arguments, plan);
  if (arguments.trials) {
    plan.trials = *arguments.trials;
    for (PlannedSet& set : plan.sets) set.trials.reset();
  }
  if (!arguments.start.empty()) plan.start_last = true;
  if (arguments.seed) plan.seed = *arguments.seed;
  if (arguments.jobs) plan.jobs = arguments.jobs;
  if (arguments.solved_at) plan.solved_at = arguments.solved_at;
  if (arguments.budget_s) plan.budget_s = *arguments.budget_s > 0 ? arguments.budget_s : std::nullopt;
  judge_engine_as_solved(plan);
  return plan;
}

/// "1:23:45", "0:04:05".
std::string clock_text(double seconds) {
  const auto whole = static_cast<std::int64_t>(seconds + 0.5);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

/// "1,234 of 5,678 cells  90/s  0:00:49 left  paper/monotone/exp1".
std::string progress_text(const Progress& progress, std::optional<double> budget_s) {
  const double rate = progress.elapsed_s > 0 ? static_cast<double>(progress.done) / progress.elapsed_s : 0.0;
  std::string left = "?";
  if (rate > 0) {
    double seconds = static_cast<double>(progress.total - progress.done) / rate;
    if (budget_s) seconds = std::min(seconds, std::max(0.0, *budget_s - progress.elapsed_s));
    left = clock_text(seconds);
  }
  return fmt::format("{} of {} cells  {}/s  {} left  {}", format_count(progress.done), format_count(progress.total),
                     format_count(static_cast<std::int64_t>(rate)), left, progress.set != nullptr ? *progress.set : "");
}

void warn_of_other_build(Store& store) {
  const Json last = last_run(store);
  const std::string commit = last.is_null() ? "" : last.value("commit", "");
  if (store.runs().empty() || commit == kBuildInfo.commit) return;
  say(stderr, "warning: {} was begun by commit '{}', this is '{}'; its cells are kept (--fresh starts anew)\n",
      store.file().string(), commit, kBuildInfo.commit);
}

/// Records in the store that a run starts: its provenance, the plan and what of it the run does.
void add_run(Store& store, const Plan& plan, const Study& study, const RunOptions& options) {
  const std::string started = utc_now();
  Json origin = provenance(typed_command_line, started);
  origin["plan"] = Json::parse(plan_json(plan));
  origin["planned"] = planned_cells(study);
  origin["seed"] = plan.seed;
  origin["jobs"] = options.jobs;
  origin["shard"] = fmt::format("{}/{}", options.shard + 1, options.shards);
  origin["skipped"] = study.skipped;
  record_run(store, started, origin);
}

/// @throws InputError if the store has answers that were judged by another bound than the plan's.
void require_bound(Store& store, const Plan& plan) {
  const auto words = [](const Json& bound) {
    return bound.is_null() ? "the default bound" : "--solved-at " + bound.dump();
  };
  const Json wanted = plan.solved_at ? Json(*plan.solved_at) : Json();
  const Json::json_pointer place("/plan/solved_at");
  for (const std::string& run : store.runs()) {
    const Json origin = Json::parse(run, nullptr, false);
    const Json bound = origin.contains(place) ? origin[place] : Json();
    if (bound == wanted) continue;
    throw InputError(fmt::format("{}: judged by {} so far, not by {}: use another store (--fresh replaces it)",
                                 store.file().string(), words(bound), words(wanted)));
  }
}

/// What the run cost, for `--costs`.
/// @param start_s  processor time before the first problem
void add_end(Store& store, const RunOptions& options, double start_s, double bytes) {
  record_run(store, "",
             {{"ended", utc_now()},
              {"jobs", options.jobs},
              {"start_s", start_s},
              {"processor_s", processor_seconds()},
              {"memory_bytes", std::max(bytes, memory_bytes())}});
}

/// The end of a run's output: how much is done, the answer, the worst problems, and the commands that show more, in
/// kAnswerLines at most. Before it, the results of every set and solver, with `all_tables` or where all fits in, and
/// the tables of the paper.
/// @param head  how much is done: whole lines
/// @param file  of the store
std::string end_text(Store& store, const report::Report& report, const std::string& head, const std::string& file,
                     bool all_tables) {
  const int width = text_width();
  const std::string first = folded(head, width);
  const auto lines = [](const std::string& text) {
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  };
  const std::string whole = results_text(store, report.summary, width);
  const std::string next = fmt::format("Every set and solver: --long\nThe report: lcpbench report {} --out FOLDER\n",
                                       shell_word(file_argument(file)));
  constexpr std::size_t kWorst = 3;  // at least so many, and more in the lines that the answer leaves
  const auto worst = [&](std::size_t free_lines) {
    return fitting_text(report.summary.solvers.size(), free_lines,
                        [&](std::size_t rows) { return worst_text(store, rows, width); });
  };
  const std::size_t free_lines = kAnswerLines - std::min(kAnswerLines, lines(first) + lines(next));
  const std::size_t kept = std::min(free_lines, lines(worst(kWorst + 2)));  // with the lines around them
  const std::string answer = answer_text(store, report, width, free_lines - kept);
  const std::string failures = worst(std::max(kept, free_lines - std::min(free_lines, lines(answer))));
  const bool fits = lines(whole) + lines(first) + lines(answer) + lines(failures) + lines(next) <= kAnswerLines;
  return (all_tables || fits ? whole : "") + paper_text(store, width) + first + answer + failures + next;
}

/// @param named  the solvers that the user named
int report_end(const RunArguments& arguments, const RunOutcome& outcome, const Plan& plan, Store& store,
               const std::vector<std::string>& named, ProgressLine& line) {
  const std::string file = store.file().string();
  const std::string done = fmt::format("{}{} of {} cells", outcome.counted ? "" : "at least ",
                                       format_count(outcome.already_done + outcome.progress.done),
                                       format_count(outcome.already_done + outcome.progress.total));
  if (outcome.end == RunEnd::kStopped) {
    say(stderr, "lcpbench: interrupted; {} are in {}: run the same command again to resume\n", done, printable(file));
    return kExitInterrupted;
  }
  line.show("reading the results");
  const report::Report report = report::read_report(store);
  report::fill_tables(store, report, named);
  line.clear();
  const std::string coverage =
      outcome.left_out.empty()
          ? report::coverage_text(report.summary.coverage)
          : counted_noun(outcome.left_out.size(), "problem") + " could not be read: named at the end\n";
  std::string head = fmt::format("{} in {}, {}\n{}", done, clock_text(outcome.progress.elapsed_s), printable(file),
                                 coverage);
  if (outcome.end == RunEnd::kOutOfBudget) {
    head += fmt::format("the plan's time budget of {:g} s is used up; run the same command again to go on\n",
                        *plan.budget_s);
  }
  say(stdout, "{}", end_text(store, report, head, file, arguments.all));
  constexpr std::size_t kMostNamed = 10;
  for (std::size_t i = 0; i < std::min(outcome.left_out.size(), kMostNamed); ++i) {
    say(stderr, "lcpbench: left out: {}\n", outcome.left_out[i]);
  }
  if (outcome.left_out.size() > kMostNamed) {
    say(stderr, "lcpbench: left out as well: {}\n", counted_noun(outcome.left_out.size() - kMostNamed, "problem"));
  }
  return outcome.left_out.empty() ? kExitDone : kExitBadInput;
}

constexpr double kMegabyte = 1 << 20;
constexpr double kMemoryMargin = 1.5;  // over the pilot's peak: larger problems may come

/// How many cells of the study the store of a shard holds; 0 where it does not exist, or its name has no {}.
std::int64_t cells_in(const Study& study, std::string file, std::int64_t shard) {
  const std::size_t place = file.find("{}");
  if (place == std::string::npos) return 0;
  file.replace(place, 2, std::to_string(shard));
  return std::filesystem::exists(file) ? done_cells(study, Store::open_for_reading(file).database()) : 0;
}

/// "1-3,7": numbers as `sbatch --array` takes them.
std::string ranges(const std::vector<std::int64_t>& numbers) {
  std::string text;
  for (std::size_t i = 0; i < numbers.size();) {
    std::size_t last = i;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    text += fmt::format("{}{}", text.empty() ? "" : ",", numbers[i]);
    if (last > i) text += fmt::format("-{}", numbers[last]);
    i = last + 1;
  }
  return text;
}

std::string cost_text(const ShardEstimate& shard) {
  return fmt::format("{} +- {}", format_seconds(shard.processor_s), format_seconds(shard.error_s));
}

/// `run --list-shards N`: prints what the shards will cost, and which of them are not finished.
/// @param stores  where {} stands for the shard's number; "": none is looked at
/// @param jobs    threads of a shard
/// @param every   in text: a line for each shard
void list_shards(const Study& study, std::int64_t shards, const std::string& stores, int jobs, bool json, bool every) {
  const std::vector<ShardEstimate> estimates = estimate_shards(study, shards);
  Json rows = Json::array();
  TextTable table({{"shard"}, {"cells"}, {"done"}, {"processor time"}});
  std::vector<std::int64_t> unfinished;
  std::int64_t cells = 0;
  double processor_s = 0;
  double longest_s = 0;
  for (const ShardEstimate& shard : estimates) {
    const std::int64_t number = std::ssize(rows) + 1;
    const std::int64_t done = std::min(shard.cells, cells_in(study, stores, number));
    rows.push_back(
        {{"cells", shard.cells}, {"done", done}, {"processor_s", shard.processor_s}, {"error_s", shard.error_s}});
    table.add_row({std::to_string(number), format_count(shard.cells), format_count(done), cost_text(shard)});
    cells += shard.cells;
    processor_s += shard.processor_s;
    if (done == shard.cells) continue;
    unfinished.push_back(number);
    longest_s = std::max({longest_s, (shard.processor_s + shard.error_s) / jobs, shard.serial_s});
  }
  const auto minutes = 1 + static_cast<std::int64_t>(std::ceil(longest_s / 60));
  const double threads = std::max(1.0, static_cast<double>(jobs) / study.costs.jobs);
  const auto megabytes =
      static_cast<std::int64_t>(std::ceil(kMemoryMargin * threads * study.costs.memory_bytes / kMegabyte));
  if (json) {
    print_json(Json{
        {"array", ranges(unfinished)}, {"minutes", minutes}, {"megabytes", megabytes}, {"shards", std::move(rows)}});
    return;
  }
  const auto [least, most] = std::minmax_element(
      estimates.begin(), estimates.end(), [](const auto& a, const auto& b) { return a.processor_s < b.processor_s; });
  say(stdout,
      "{}{} of {} cells\n"
      "processor time: {} in all; the cheapest shard {}, the dearest {} (two standard deviations)\n"
      "time limit of a shard with {}: {} minutes\n"
      "memory of a shard: {} MB\n"
      "shards to run: {}\n",
      every ? table.text() + "\n" : "", counted_noun(estimates.size(), "shard"), format_count(cells),
      format_seconds(processor_s), cost_text(*least), cost_text(*most),
      counted_noun(static_cast<std::size_t>(jobs), "thread"), minutes, format_count(megabytes),
      unfinished.empty() ? "none" : ranges(unfinished));
}

int run(const RunArguments& arguments) {
  const Plan plan = make_plan(arguments);
  RunOptions options;
  options.jobs = plan.jobs.value_or(processors());
  set_shard(arguments.shard, options);
  ProgressLine line;
  line.show("opening the sets and solvers of the plan " + plan.name);
  Study study = resolve(plan);
  if (!arguments.costs.empty()) study.costs = measured_costs(open_checked(arguments.costs).database());
  line.clear();
  for (const std::string& solver : study.skipped) say(stderr, "skipped: {}\n", solver);
  for (const StudySet& set : study.sets) {
    if (const std::string note = set.set->note(); !note.empty()) say(stderr, "{}\n", printable(note));
  }
  say(stderr, "{}", left_out_text(study));
  if (study.solvers.empty()) {
    const char* const cause = study.left_out.empty() ? "runs on the sets of --set" : "is available";
    throw InputError(fmt::format("plan {}: none of its solvers {}", plan.name, cause));
  }

  if (arguments.list_shards) {
    list_shards(study, *arguments.list_shards, arguments.store, options.jobs, arguments.json, arguments.all);
    return kExitDone;
  }
  const std::filesystem::path file = arguments.store.empty() ? plan.name + ".db" : arguments.store;
  if (arguments.fresh) Store::remove(file);
  Store store = Store::open_for_writing(file, told_on_stderr());
  print_notice(store);
  require_bound(store, plan);
  warn_of_other_build(store);

  std::vector<std::string> named;
  for (const StudySolver& solver : study.solvers) {
    if (arguments.solvers.empty() || std::ranges::find(named, solver.row.text()) != named.end()) continue;
    named.push_back(solver.row.text());
  }
  options.stop = catch_interrupts(kExitInterrupted);
  double bytes = 0;
  double next_look_s = 0;
  options.on_progress = [&](const Progress& progress) {
    if (progress.elapsed_s >= next_look_s) {
      bytes = std::max(bytes, memory_bytes());
      next_look_s = progress.elapsed_s + 1;
    }
    if (progress.total > 0) line.show(progress_text(progress, plan.budget_s));
  };
  if (isatty(STDOUT_FILENO) == 1) {  // a file or a program that reads this wants the end, and it once
    options.on_partial_results = [&](Store& partial) {
      line.clear();
      const report::Report report = report::read_report(partial);
      report::fill_tables(partial, report, named);
      say(stdout, "so far:\n{}\n", answer_text(partial, report, text_width(), kAnswerLines));
      std::fflush(stdout);
    };
  }
  line.show(fmt::format("plan {}: {} and {}, into {}", plan.name, counted_noun(study.sets.size(), "set"),
                        counted_noun(study.solvers.size(), "solver"), file.string()));
  add_run(store, plan, study, options);
  const double start_s = processor_seconds();
  const RunOutcome outcome = run_study(study, store, options);
  line.clear();
  add_end(store, options, start_s, bytes);
  return report_end(arguments, outcome, plan, store, named, line);
}

}  // namespace

Action add_run_command(CLI::App& command) {
  const auto arguments = std::make_shared<RunArguments>();
  command.add_option("PLAN", arguments->plan,
                     fmt::format("built-in plan ({}) or plan file; default {} (with --set: none)",
                                 fmt::join(builtin_plan_names(), ", "), kDefaultPlan));
  add_repeatable(command, "--set", arguments->sets, "problem set or glob, instead of the plan's; may be repeated");
  add_repeatable(command, "--solver", arguments->solvers,
                 "name{key=value,...}, instead of the plan's; may be repeated");
  command
      .add_option("--start", arguments->start,
                  "last: solvers that take a start run a second time on consecutive steps of simulations, each from "
                  "its own last answer; their settings then say start=last")
      ->check(CLI::IsMember({"last"}));
  command.add_option("--sweep", arguments->sweep, "run each solver over its grid of this name (paper)");
  command
      .add_option("--trials", arguments->trials, "problems of each set (default: the plan's; of --set file:PATH all)")
      ->check(CLI::Range(INT64_C(1), kMaxTrials));
  command.add_option("--seed", arguments->seed, "stream of random problems")->check(seed_check());
  command.add_option("--jobs", arguments->jobs, "threads (default: one per processor)")->check(CLI::Range(1, 1024));
  command.add_option("--budget", arguments->budget_s, "seconds after which no problem is begun; 0: no limit")
      ->check(number_check(0, 1e7));
  add_solved_at(command, arguments->solved_at);
  command.add_option("--store", arguments->store, "file of the results (default: PLAN.db)");
  command.add_option("--shard", arguments->shard, "I/N: only the I-th of N parts, for lcpbench merge");
  CLI::Option* const costs =
      command.add_option("--costs", arguments->costs,
                         "store of a small run of the plan: shards cost alike by its times; the same for all shards");
  command
      .add_option("--list-shards", arguments->list_shards,
                  "run nothing: print what each of N shards will cost, and which are not finished "
                  "(--store 'shard-{}.db')")
      ->check(CLI::Range(1, 1'000'000))
      ->needs(costs);
  command.add_flag("--fresh", arguments->fresh, "throw the store away first");
  command.add_flag("--long", arguments->all, "show the results of every set and solver before the answer");
  add_output_options(command, arguments->json);
  command.footer(
      "A problem that cannot be read is left out and named at the end (exit code 2). "
      "Every finished cell (set x trial x solver) is kept: an interrupted run goes on where it stopped. Ctrl-C "
      "saves and ends (exit code 3); a second Ctrl-C ends at once. docs/reference/plans.md documents plan files.");
  return [arguments] { return run(*arguments); };
}

}  // namespace lcpbench
