#include <algorithm>
#include <cerrno>
#include <exception>
#include <iostream>
#include <sstream>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include "adapters/worker/worker_client.h"
#include "core/suggestion.h"
#include "core/utf8.h"
#include "study/commands/commands.h"
#include "study/run/build_info.h"

namespace {

using namespace lcpbench;

std::string command_line(int argc, const char* const* argv) {
  std::string text = "lcpbench";
  for (int i = 1; i < argc; ++i) text += " " + shell_word(argv[i]);
  return text;
}

/// A file opened later must not get the number of a closed standard stream: what is printed would end up in it.
/// Standard output that was closed stays one that nothing can be written to, so that what is printed is an error.
void open_closed_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) < 0) open("/dev/null", stream == STDOUT_FILENO ? O_RDONLY : O_RDWR);
  }
}

/// Stores and JSON hold UTF-8 alone. What cannot be kept is refused before anything is made.
void check_arguments(int argc, const char* const* argv) {
  for (int i = 1; i < argc; ++i) {
    if (!is_utf8(argv[i])) throw InputError(fmt::format("argument {} ('{}') is not UTF-8", i, printable(argv[i])));
  }
}

/// Output that did not arrive (a full disk) must not look like success. @throws std::system_error
void flush_output() {
  errno = 0;
  std::cout.flush();
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good()) return;
  throw std::system_error(errno != 0 ? errno : EIO, std::generic_category(), "standard output");
}

std::string first_line(std::string text) { return text.substr(0, text.find('\n')); }

/// What an option does begins in a column of its own, behind a long option on the next line; a paragraph begins at the
/// left.
std::string folded_help(const std::string& help) {
  constexpr std::size_t kColumn = 30;
  std::string text;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t indent = std::min(line.find_first_not_of(' '), line.size());
    text += folded(line + "\n", terminal_width(), indent > 0 ? kColumn - std::min(indent, kColumn) : 0);
  }
  return text;
}

/// A clause on the first option that the command typed does not have: see did_you_mean.
std::string closest_option(const CLI::App& app) {
  for (const CLI::App* command : app.get_subcommands()) {
    std::vector<std::string> known;
    for (const CLI::Option* option : command->get_options()) {
      for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
    }
    for (const std::string& argument : command->remaining()) {
      if (argument.starts_with("--")) return did_you_mean(argument.substr(0, argument.find('=')), known);
    }
  }
  return "";
}

/// Reads the command line and does what it says. @returns the exit code. @throws InputError
int run(int argc, const char* const* argv) {
  CLI::App app("Compares LCP and contact solvers. Code that is independent of all solvers checks every answer.");
  app.name("lcpbench");
  app.set_version_flag("--version", std::string("lcpbench ") + kBuildInfo.version);
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done; 1 a check failed; 2 bad usage or input; 3 interrupted (`run` and `replay` go on if called "
      "again).");
  std::vector<std::string> names;
  Action chosen;
  const auto add = [&](const char* name, const char* summary, Action (*declare)(CLI::App&)) {
    CLI::App* command = app.add_subcommand(name, summary);
    command->callback([&chosen, action = declare(*command)] { chosen = action; });
    names.emplace_back(name);
  };
  add("solvers", "List every solver, also those that cannot run here", add_solvers_command);
  add("steppers", "List every way to take a time step", add_steppers_command);
  add("sets", "List every problem set", add_sets_command);
  add("generate", "Write problems of a set as files", add_generate_command);
  add("dataset", "Write captured and made problems with verified answers into a folder", add_dataset_command);
  add("capture", "Run a physics engine on a scene and write the contact problems of its steps", add_capture_command);
  add("inspect", "Say what problem files are, and what looks wrong or hard in them", add_inspect_command);
  add("audit", "Count the contacts that an engine left out, and measure what they would change", add_audit_command);
  add("solve", "Solve problem files and verify the answers", add_solve_command);
  add("shrink", "Look for the smallest problem on which a solver still fails", add_shrink_command);
  add("models", "Solve problem files with models of friction from coarse to exact", add_models_command);
  add("replay", "Step scenes on in several ways; show what each does to them and what it costs", add_replay_command);
  add("view", "Write a page that shows a step, or replays, in 3D", add_view_command);
  add("certify", "Prove whether problems have a solution", add_certify_command);
  add("run", "Run a study into a store; resumes by default", add_run_command);
  add("merge", "Join the stores of shards", add_merge_command);
  add("query", "Ask a store by a query of the report, or one of your own", add_query_command);
  add("report", "Write the report of a store: page, tables, report.json, summary.json", add_report_command);
  add("compare", "Compare two stores: what got better, worse, or is a tie", add_compare_command);
  add("bench", "Measure speed against a reference solver", add_bench_command);
  add("stability", "Perturb problems in known ways; report which solvers' answers change or fail",
      add_stability_command);
  add("validate", "Compare our solvers with the reference libraries, problem by problem", add_validate_command);

  if (argc == 1) {
    say(stdout, "{}", folded_help(app.help()));
    return kExitDone;
  }
  const std::string first = argv[1];
  const bool known = std::find(names.begin(), names.end(), first) != names.end();
  if (!known && !first.starts_with('-')) {
    throw InputError(fmt::format("unknown command '{}'{} (lcpbench --help)", first, did_you_mean(first, names)));
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    say(stdout, "{}", folded_help(app.help()));
    return kExitDone;
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    const bool unexpected = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
    throw InputError(fmt::format("{}{} (lcpbench {}--help)", first_line(error.what()),
                                 unexpected ? closest_option(app) : "", known ? first + " " : ""));
  }
  return chosen();
}

}  // namespace

int main(int argc, char** argv) {
  open_closed_streams();
  announce_interrupts(kExitInterrupted);
  try {
    check_arguments(argc, argv);
    typed_command_line = command_line(argc, argv);
    const int exit_code = run(argc, argv);
    flush_output();
    return exit_code;
  } catch (const InputError& error) {
    say(stderr, "lcpbench: {}\n", error.what());
  } catch (const WorkerError& error) {
    say(stderr, "lcpbench: {}\n", error.what());
  } catch (const std::system_error& error) {
    const bool crowded = error.code() == std::errc::resource_unavailable_try_again;
    say(stderr, "lcpbench: {}{}\n", error.what(),
        crowded ? ": no more threads and processes are allowed (ulimit -u)" : "");
  } catch (const std::exception& error) {
    say(stderr, "lcpbench: internal error: {}\n", error.what());
  }
  return kExitBadInput;
}
