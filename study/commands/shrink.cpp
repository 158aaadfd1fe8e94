#include "study/shrink/shrink.h"

#include <system_error>

#include "core/io/problem_checks.h"
#include "core/io/problem_io.h"
#include "core/io/whole_file.h"
#include "core/spec.h"
#include "core/timed_solve.h"
#include "study/commands/commands.h"
#include "study/commands/problem_files.h"
#include "study/shrink/failure.h"
#include "study/shrink/pieces.h"

namespace lcpbench {
namespace {

constexpr double kTimeLimitS = 10;  // the default of `solve` too
constexpr double kProofTimeS = 10;

struct ShrinkArguments {
  std::string file;
  std::string solver;
  std::string until;
  std::string against;
  double speed = 1e-3;
  std::string out;
  double time_limit_s = kTimeLimitS;
  double budget_s = 120;
  bool json = false;
};

/// @throws InputError when the file that is asked for cannot become one: before any work is done
void check_out(const std::string& out, const std::string& file) {
  namespace fs = std::filesystem;
  if (!out.ends_with(".json")) {
    throw InputError(fmt::format("--out '{}': a problem file's name ends in .json", out));
  }
  refuse_inputs(out, {file});
  std::error_code error;
  const fs::path folder = fs::path(out).parent_path();
  if (!folder.empty() && !fs::is_directory(folder, error)) {
    throw InputError(fmt::format("--out '{}': there is no folder {}", out, folder.string()));
  }
}

FailureOptions failure_options(const ShrinkArguments& arguments) {
  FailureOptions options;
  options.solver = parse_spec(arguments.solver);
  for (const FailureKind kind : {FailureKind::kWrong, FailureKind::kMissed, FailureKind::kDiffers}) {
    if (arguments.until == to_string(kind)) options.kind = kind;
  }
  if (!arguments.against.empty()) {  // two solvers are compared by `differs` alone
    if (options.kind.value_or(FailureKind::kDiffers) != FailureKind::kDiffers) {
      throw InputError(fmt::format("--against '{}': only --until differs compares two solvers", arguments.against));
    }
    options.kind = FailureKind::kDiffers;
    options.against = arguments.against;
  }
  options.speed = arguments.speed;
  options.time_limit_s = arguments.time_limit_s;
  return options;
}

/// The problem as a file of this name will hold it.
Problem as_read(const Problem& problem, const std::string& name) {
  Problem named;
  if (problem.scene() != nullptr) {
    named = {name, *problem.scene()};
  } else if (problem.contact() != nullptr) {
    named = {name, *problem.contact()};
  } else {
    named = {name, problem.lcp()};
  }
  return parse_problem_json(problem_json(named), name);
}

/// The name of the problem, with the solver and how it fails; "shrunk" where that is too long.
std::string name_of_result(const Problem& problem, const FailureTest& test) {
  const std::string how = test.other().empty() ? std::string(to_string(test.kind())) : "differs from " + test.other();
  const std::string words = fmt::format(" (shrunk: {} {})", test.solver().text(), how);
  const std::string& name = problem.name();
  return name.size() + words.size() <= kMaxNameBytes ? name + words : "shrunk";
}

std::string replay_command(const ShrinkArguments& arguments, const FailureTest& test) {
  const std::string out = shell_word(file_argument(arguments.out));
  std::string command =
      fmt::format("lcpbench solve {} --solver {}", out, shell_word(test.solver().text()));
  const bool certificate = test.other() == "certificate";
  if (test.other().empty() && test.solver().text() != "auto") command += " --solver auto";
  if (!test.other().empty() && !certificate) command += " --solver " + shell_word(test.other());
  if (arguments.time_limit_s != kTimeLimitS) command += fmt::format(" --time-limit {:g}", arguments.time_limit_s);
  return certificate ? command + " && lcpbench certify " + out : command;
}

/// What exact arithmetic proves of the result.
struct Proof {
  Certificate certificate;
  std::string words = "nothing was proven of the result";
};

Proof prove(const Problem& problem, FailureKind kind) {
  Proof proof;
  Certifier certifier({.time_limit_s = kProofTimeS, .seek_other_velocity = kind == FailureKind::kDiffers});
  proof.certificate = certifier.certify(problem);
  const Certificate& certificate = proof.certificate;
  if (certificate.kind == CertificateKind::kUnsolvable) {
    proof.words = "proven in exact arithmetic: the problem has no solution";
  } else if (certificate.kind == CertificateKind::kSolution) {
    proof.words = "proven in exact arithmetic: the problem has a solution";
    if (certificate.velocity_unique) {
      proof.words += *certificate.velocity_unique ? ", and all its solutions have one velocity"
                                                  : ", and another one with another velocity";
    }
  }
  return proof;
}

Json size_json(const Problem& problem) {
  const ProblemSize size = problem_size(problem);
  return {{"contacts", size.contacts},
          {"rows", size.rows},
          {"bodies", size.bodies},
          {"friction_edges", size.friction_edges},
          {"numbers", size.numbers},
          {"digits", size.digits}};
}

struct ShrinkOutcome {
  Problem start;
  Shrunk shrunk;
  std::string words;  ///< what happens on the result
  double seconds = 0;
  Proof proof;
};

void print_outcome(const ShrinkArguments& arguments, const FailureTest& test, const ShrinkOutcome& outcome) {
  const Certificate& certificate = outcome.proof.certificate;
  const std::string replay = replay_command(arguments, test);
  if (arguments.json) {
    print_json({{"problem", problem_summary_json(outcome.shrunk.problem, arguments.out)},
                {"solver", test.solver().text()},
                {"until", to_string(test.kind())},
                {"against", test.other().empty() ? Json() : Json(test.other())},
                {"failure", outcome.words},
                {"before", size_json(outcome.start)},
                {"after", size_json(outcome.shrunk.problem)},
                {"tries", outcome.shrunk.tries},
                {"complete", outcome.shrunk.complete},
                {"seconds", json_number(outcome.seconds)},
                {"certificate", to_string(certificate.kind)},
                {"velocity_unique", json_optional(certificate.velocity_unique)},
                {"out", arguments.out},
                {"replay", replay}});
    return;
  }
  const ProblemSize before = problem_size(outcome.start);
  const ProblemSize after = problem_size(outcome.shrunk.problem);
  TextTable table({{"", TextTable::Align::kLeft}, {"before"}, {"after"}});
  const auto row = [&](const char* what, Index from, Index to) {
    if (from > 0) table.add_row({what, std::to_string(from), std::to_string(to)});
  };
  const ProblemKind kind = outcome.start.kind();
  row(kind == ProblemKind::kLcp ? "rows" : "contacts", before.contacts, after.contacts);
  row("bounded rows", before.rows, after.rows);
  row(kind == ProblemKind::kScene ? "bodies" : "coordinates", before.bodies, after.bodies);
  row("friction edges", before.friction_edges, after.friction_edges);
  row("numbers that are not zero", before.numbers, after.numbers);
  row("their decimal digits", before.digits, after.digits);
  say(stdout, "{}", table.text(text_width()));
  say_folded("{}\n{}\n", outcome.words, outcome.proof.words);
  const char* end = outcome.shrunk.complete ? "nothing more can be left out" : "more may be possible with more time";
  say_folded("{} problems tried in {:.1f} s; {}\n", outcome.shrunk.tries, outcome.seconds, end);
  say(stdout, "repeat: {}\n", replay);
}

int run_shrink(const ShrinkArguments& arguments) {
  check_out(arguments.out, arguments.file);
  const volatile std::sig_atomic_t* stop = catch_interrupts(kExitInterrupted);
  WholeFile out(arguments.out);
  const Problem problem = interruptibly([&] { return read_named_problem(arguments.file); });
  const double began_s = wall_clock_s();
  const FailureOptions failure = failure_options(arguments);
  FailureTest test(failure);
  ShrinkOutcome outcome;
  outcome.start = as_read(problem, "start");
  if (!test.begin(outcome.start)) {
    say(stderr, "lcpbench: {}: nothing to shrink{}: {}\n", printable(arguments.file),
        failure.kind ? fmt::format(" until {}", to_string(*failure.kind)) : "", test.words());
    return *stop != 0 ? kExitInterrupted : kExitCheckFailed;
  }
  outcome.start = as_read(problem, name_of_result(problem, test));
  ProgressLine progress;
  ShrinkOptions options;
  options.budget_s = arguments.budget_s;
  options.stop = stop;
  const Index all_contacts = contact_count(outcome.start);
  options.progress = [&](const Problem& smallest, std::int64_t tries) {
    progress.show(fmt::format("{} of {} contacts, {} problems tried", contact_count(smallest), all_contacts, tries));
  };
  outcome.shrunk = shrink(
      outcome.start, [&](const Problem& candidate) { return test.fails(candidate); }, options);
  progress.clear();
  const std::string text = problem_json(outcome.shrunk.problem);
  if (!test.fails(parse_problem_json(text, arguments.out))) {
    say(stderr, "lcpbench: {} does not fail again on what it failed on: its answers are not reproducible, and nothing "
                "is written\n",
        test.solver().text());
    return kExitCheckFailed;
  }
  out.write(text);
  out.commit();
  outcome.words = test.words();
  if (*stop == 0) outcome.proof = prove(outcome.shrunk.problem, test.kind());
  outcome.seconds = wall_clock_s() - began_s;
  print_outcome(arguments, test, outcome);
  return *stop != 0 ? kExitInterrupted : kExitDone;
}

}  // namespace

Action add_shrink_command(CLI::App& command) {
  const auto arguments = std::make_shared<ShrinkArguments>();
  command.add_option("FILE", arguments->file, "problem file, or F.scenes#STEP")->required();
  command.add_option("--solver", arguments->solver, "the solver that fails: name{key=value,...}")->required();
  command
      .add_option("--until", arguments->until,
                  "how it fails: wrong (a false claim), missed (a solvable problem not solved, or a crash) or differs "
                  "(two verified answers move differently); default: differs with --against, else the first of these "
                  "that it does")
      ->check(CLI::IsMember({"wrong", "missed", "differs"}));
  command.add_option("--against", arguments->against,
                     "differs: the other solver, or certificate (default: auto, certificate, then each of lcpbench's "
                     "own solvers, the first that differs)");
  add_number(command, "--speed", arguments->speed, "differs: the velocities differ at least by this [m/s, rad/s]",
             number_check(1e-300, 1e300));
  command.add_option("--out", arguments->out, "the smallest problem found, a file NAME.json")->required();
  add_number(command, "--time-limit", arguments->time_limit_s, "seconds for each solve", number_check());
  add_number(command, "--budget", arguments->budget_s, "seconds after which no smaller problem is tried",
             number_check(0, 1e9));
  add_output_options(command, arguments->json);
  command.footer(
      "Leaves out contacts, bounded rows, bodies and friction, and rounds numbers, as long as the solver fails in the "
      "same way. Exit code 1: it does not fail on FILE, or not again; nothing is written. Ctrl-C writes the smallest "
      "problem until then (exit code 3). See docs/howto/report-a-failing-case.md.");
  return [arguments] { return run_shrink(*arguments); };
}

}  // namespace lcpbench
