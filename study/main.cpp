#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <iostream>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "adapters/worker/worker_client.h"
#include "core/error.h"
#include "core/suggestion.h"
#include "core/utf8.h"
#include "study/commands/commands.h"
#include "study/output/terminal.h"
#include "study/output/text_table.h"
#include "study/run/build_info.h"
#include "study/run/interrupt.h"

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

class CommandLine {
 public:
  CommandLine()
      : app_("Compares LCP and contact solvers. Code that is independent of all solvers checks every answer.") {
    app_.name("lcpbench");
    app_.set_version_flag("--version", std::string("lcpbench ") + kBuildInfo.version);
    app_.require_subcommand(1);
    app_.footer(
        "Exit codes: 0 done; 1 a check failed; 2 bad usage or input; 3 interrupted (`run` and `replay` go on if called "
        "again).");
    add("solvers", "List every solver, also those that cannot run here", add_solvers_command);
    add("steppers", "List every way to take a time step", add_steppers_command);
    add("sets", "List every problem set", add_sets_command);
    add("generate", "Write problems of a set as files", add_generate_command);
    add("capture", "Run a physics engine on a scene and write the contact problems of its steps", add_capture_command);
    add("import", "Turn files of other programs into a scenes file", add_import_command);
    add("inspect", "Say what problem files are, and what looks wrong or hard in them", add_inspect_command);
    add("solve", "Solve problem files and verify the answers", add_solve_command);
    add("shrink", "Look for the smallest problem on which a solver still fails", add_shrink_command);
    add("models", "Solve problem files with models of friction from coarse to exact", add_models_command);
    add("replay", "Step scenes on in several ways; show what each does to them and what it costs",
        add_replay_command);
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
  }

  int run(int argc, const char* const* argv) {
    if (argc > 1 && argv[1][0] != '-' && !is_command(argv[1])) {
      throw InputError(
          fmt::format("unknown command '{}'{} (lcpbench --help)", argv[1], did_you_mean(argv[1], command_names())));
    }
    try {
      app_.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
      say(stdout, "{}", folded_help(app_.help()));
      return kExitDone;
    } catch (const CLI::Success& success) {
      return app_.exit(success);
    } catch (const CLI::ParseError& error) {
      const bool known = argc > 1 && is_command(argv[1]);
      const bool unexpected = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
      throw InputError(fmt::format("{}{} (lcpbench {}--help)", first_line(error.what()),
                                   unexpected ? closest_option() : "", known ? std::string(argv[1]) + " " : ""));
    }
    for (const auto& [command, action] : commands_) {
      if (command->parsed()) return action();
    }
    return kExitBadInput;
  }

 private:
  std::vector<std::string> command_names() const {
    std::vector<std::string> names;
    for (const auto& [command, action] : commands_) names.push_back(command->get_name());
    return names;
  }
  bool is_command(const std::string& name) const {
    const std::vector<std::string> names = command_names();
    return std::find(names.begin(), names.end(), name) != names.end();
  }
  /// See did_you_mean: for the first option that the command typed does not have.
  std::string closest_option() const {
    for (const auto& [command, action] : commands_) {
      if (!command->parsed()) continue;
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

  void add(const char* name, const char* summary, Action (*add_options)(CLI::App&)) {
    CLI::App* command = app_.add_subcommand(name, summary);
    commands_.emplace_back(command, add_options(*command));
  }

  CLI::App app_;
  std::vector<std::pair<CLI::App*, Action>> commands_;
};

}  // namespace

int main(int argc, char** argv) {
  open_closed_streams();
  announce_interrupts(kExitInterrupted);
  try {
    check_arguments(argc, argv);
    typed_command_line = command_line(argc, argv);
    const int exit_code = CommandLine().run(argc, argv);
    flush_output();
    return exit_code;
  } catch (const InputError& error) {
    say(stderr, "lcpbench: {}\n", error.what());
  } catch (const WorkerError& error) {
    say(stderr, "lcpbench: {}\n", error.what());
  } catch (const std::system_error& error) {
    say(stderr, "lcpbench: {}\n", error.what());
  } catch (const std::exception& error) {
    say(stderr, "lcpbench: internal error: {}\n", error.what());
  }
  return kExitBadInput;
}
