#include "study/validate/validate.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <map>
#include <set>
#include <system_error>
#include <tuple>

#include <unistd.h>

#include "core/io/problem_io.h"
#include "core/io/whole_file.h"
#include "study/commands/commands.h"
#include "study/commands/stores.h"
#include "study/output/columns.h"
#include "study/output/csv.h"
#include "study/report/text.h"
#include "study/run/plan.h"
#include "study/run/provenance.h"
#include "study/run/runner.h"
#include "study/summary/coverage.h"

namespace lcpbench {
namespace {

/// Most problems that are saved for one set, pair of solvers and outcome.
constexpr int kSavedOfAKind = 3;

struct ValidateArguments {
  std::vector<std::string> sets;
  std::vector<std::string> solvers;
  std::int64_t trials = 1000;
  std::uint64_t seed = 1;
  std::optional<double> time_limit_s;
  std::optional<int> jobs;
  std::string store;
  std::filesystem::path out;
  bool each_reference = false;
  bool json = false;
};

Plan make_plan(const ValidateArguments& arguments) {
  std::vector<Spec> asked;
  for (const std::string& solver : arguments.solvers) asked.push_back(parse_spec(solver));
  Plan plan = validation_plan(asked, arguments.sets, arguments.trials);
  if (arguments.time_limit_s) plan.time_limit_s = *arguments.time_limit_s;
  plan.seed = arguments.seed;
  return plan;
}

/// Makes a new folder among the temporary files.
std::filesystem::path make_own_folder() {
  std::error_code none;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(none);
  if (none) throw InputError(fmt::format("TMPDIR '{}' is no folder", std::getenv("TMPDIR")));  // else it is /tmp
  std::string pattern = (folder / "lcpbench-validate-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) {
    throw InputError(fmt::format("{}: cannot be made: {} (TMPDIR names another folder)", pattern,
                                 std::error_code(errno, std::generic_category()).message()));
  }
  return pattern;
}

/// A store for the answers of this run alone. Its files lose their names as soon as they are open, so that nothing is
/// left behind however the program ends.
Store nameless_store() {
  struct RemovedAtEnd {
    std::filesystem::path folder;
    ~RemovedAtEnd() {
      std::error_code ignored;
      std::filesystem::remove_all(folder, ignored);
    }
  };
  const RemovedAtEnd removed{make_own_folder()};
  return Store::open_for_writing(removed.folder / "answers.db");
}

void warn_without_references(const Study& study) {
  const bool any = std::any_of(study.solvers.begin(), study.solvers.end(),
                               [](const StudySolver& solver) { return !is_ours(find_solver(solver.row.name)); });
  if (!any) say(stderr, "lcpbench: no reference library is available here: only what theory proves is compared\n");
}

/// False when it was interrupted.
bool solve_all(const Study& study, Store& store, bool kept, std::optional<int> jobs) {
  RunOptions options;
  options.store_is_kept = kept;
  options.jobs = jobs.value_or(processors());
  options.stop = catch_interrupts(kExitInterrupted);
  ProgressLine line;
  line.show(fmt::format("validating {} on {}", counted_noun(study.solvers.size(), "solver"),
                        counted_noun(study.sets.size(), "set")));
  options.on_progress = [&line](const Progress& progress) {
    line.show(fmt::format("{} of {} answers", format_count(progress.done), format_count(progress.total)));
  };
  const RunOutcome outcome = run_study(study, store, options);
  if (!outcome.left_out.empty()) throw InputError(outcome.left_out.front());
  return outcome.end == RunEnd::kComplete;
}

void print_matrix(const Validation& validation, bool each_reference) {
  using Align = TextTable::Align;
  const std::vector<JsonColumn> columns{{{"ours", Align::kLeft}, field("native")},
                                        {{"reference", Align::kLeft}, field("reference")},
                                        {{"compared"}, field("compared")},
                                        {{"agree", Align::kRight, 3}, field("agree")},
                                        {{"ours wrong"}, field("native_wrong")},
                                        {{"theirs wrong"}, field("reference_wrong")},
                                        {{"both wrong", Align::kRight, 1}, field("both_wrong")},
                                        {{"undecided", Align::kRight, 2}, field("undecided")}};
  say(stdout, "{}", table_text(columns, each_reference ? validation.over_sets : validation.totals));
}

/// Writes problems of the disagreements, at most kSavedOfAKind of each kind, and an index of them. @returns how many
/// problems were written
std::size_t save(const Study& study, const Json& disagreements, const std::filesystem::path& folder) {
  WholeFile index(folder / "disagreements.csv");
  Json rows = Json::array();
  std::map<std::tuple<Json, Json, Json, Json>, int> seen;
  std::set<std::string> written;
  for (const Json& found : disagreements) {
    if (++seen[{found["place"], found["ours"], found["reference"], found["outcome"]}] > kSavedOfAKind) continue;
    const auto place = found["place"].get<std::size_t>();  // two sets may have one stem
    const ProblemSet& set = *study.sets[place].set;
    const auto trial = found["trial"].get<std::int64_t>();
    const std::string file = fmt::format("{}-{}-{}.json", report::file_stem(set.name()), place + 1, trial);
    if (written.insert(file).second) write_problem(set.generate(study.seed, trial), folder / file);
    rows.push_back({{"file", file}});
    rows.back().update(found);
    rows.back().erase("place");
  }
  index.write(csv_table(rows));
  index.commit();
  return written.size();
}

void print_verdict(const Validation& validation) {
  const auto two_velocities = std::count_if(validation.disagreements.begin(), validation.disagreements.end(),
                                            [](const Json& each) { return each["outcome"] == "undecided"; });
  if (two_velocities > 0) {
    say(stdout, "\n{} of the undecided: both verified, with two velocities where there is only one\n",
        format_count(two_velocities));
  }
  if (!validation.ours_wrong()) {
    say(stdout, "\nno false claim of ours\n");
    return;
  }
  say(stdout, "\nOURS IS WRONG:\n");
  for (const Json& pair : validation.pairs) {
    const auto wrong = pair["native_wrong"].get<std::int64_t>() + pair["both_wrong"].get<std::int64_t>();
    if (wrong == 0) continue;
    const auto name = [&pair](const char* key) { return pair[key].get<std::string>(); };
    say(stdout, "  {} on {}: {} of {} compared with {}\n", name("native"), name("set"), wrong,
        pair["compared"].get<std::int64_t>(), name("reference"));
  }
}

int run_validation(const ValidateArguments& arguments) {
  const Plan plan = make_plan(arguments);
  const Study study = validation_study(plan);
  say(stderr, "{}", left_out_text(study));
  if (!arguments.out.empty()) make_folder(arguments.out);  // before hours are spent on answers
  warn_without_references(study);
  Json origin = provenance(typed_command_line, utc_now());
  origin["plan"] = Json::parse(plan_json(plan));
  const bool kept = !arguments.store.empty();
  Validation validation;
  bool complete = true;
  {
    Store store = kept ? Store::open_for_writing(arguments.store, told_on_stderr()) : nameless_store();
    print_notice(store);
    Json run = origin;
    run["planned"] = planned_cells(study);
    record_run(store, run["started"], run);
    complete = solve_all(study, store, kept, arguments.jobs);
    if (!complete) {
      say(stderr, "lcpbench: interrupted; {}\n",
          kept ? "run the same command again to resume"
               : "only the answers until now are compared (--store FILE keeps them)");
      if (kept) return kExitInterrupted;
    }
    validation = validate(study, store);
  }
  if (arguments.json) {
    print_json({{"provenance", origin}, {"pairs", validation.pairs}, {"ok", !validation.ours_wrong()}});
  } else {
    print_matrix(validation, arguments.each_reference);
    print_verdict(validation);
  }
  const bool disagree = !validation.disagreements.empty();
  if (disagree && !arguments.out.empty()) {
    const std::size_t files = save(study, validation.disagreements, arguments.out);
    say(stderr, "{} problems on which two disagree are in {}; lcpbench solve replays them\n", files,
        printable(arguments.out.string()));
  } else if (disagree) {
    say(stderr, "--out FOLDER keeps some of the problems on which two disagree\n");
  }
  if (!complete) return kExitInterrupted;
  return validation.ours_wrong() ? kExitCheckFailed : kExitDone;
}

}  // namespace

Action add_validate_command(CLI::App& command) {
  const auto arguments = std::make_shared<ValidateArguments>();
  add_repeatable(command, "--set", arguments->sets,
                 "problem set or glob, run with every solver; may be repeated\n(default: small rigid scenes, planted "
                 "problems, and a selection of the paper's)");
  add_repeatable(command, "--solver", arguments->solvers,
                 "name{key=value,...}: ours, compared with the references among them, or with all\nthat are available; "
                 "may be repeated (default: all)");
  add_number(command, "--trials", arguments->trials, "problems of each set", CLI::Range(1, 100'000'000));
  add_number(command, "--seed", arguments->seed, "stream of random problems", seed_check());
  add_number(command, "--time-limit", arguments->time_limit_s, "seconds for each solve (default 2)",
             number_check(1e-3, 1e6));
  add_number(command, "--jobs", arguments->jobs, "threads (default: one per processor)", CLI::Range(1, 1024));
  command.add_option("--store", arguments->store, "keep the answers in this file, and resume from it");
  command.add_option("--out", arguments->out, "folder for some of the problems on which two disagree");
  command.add_flag("--long", arguments->each_reference, "show each of ours with each reference, not the sums alone");
  add_output_options(command, arguments->json);
  command.footer(
      "Our solvers against the reference libraries and against what theory proves, problem by problem. Verdicts "
      "are the evaluation's. Exit code 1 when one of ours made a false claim. See docs/howto/compare.md.");
  return [arguments] { return run_validation(*arguments); };
}

}  // namespace lcpbench
