#pragma once

// What the commands share: exit codes, options and their checks; and how each command is declared.

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "core/error.h"
#include "core/spec.h"
#include "study/output/json_output.h"
#include "study/output/terminal.h"
#include "study/run/interrupt.h"

namespace lcpbench {

struct Study;

/// Exit codes of the program.
inline constexpr int kExitDone = 0;
inline constexpr int kExitCheckFailed = 1;
inline constexpr int kExitBadInput = 2;
inline constexpr int kExitInterrupted = 3;

/// The command line as typed, for the provenance of results. main() sets it.
inline std::string typed_command_line;

/// The scenes that `capture` and `replay` know, for the end of their help.
std::string list_of_scenes();

/// What a command does once its arguments are parsed. @returns the exit code. @throws InputError
using Action = std::function<int()>;

/// `--format text|json`, which sets `json`, and `--wide`, which ends the limit on the width of lines.
void add_output_options(CLI::App& command, bool& json);

/// An option that may be given several times, each time with one value.
CLI::Option* add_repeatable(CLI::App& command, const std::string& name, std::vector<std::string>& values,
                            const std::string& help);

/// An option that takes a number. The help shows its default, unless it is a std::optional.
template <class Number>
CLI::Option* add_number(CLI::App& command, const std::string& name, Number& value, const std::string& help,
                        const CLI::Validator& check) {
  CLI::Option* option = command.add_option(name, value, help)->check(check);
  if constexpr (std::is_arithmetic_v<Number>) option->capture_default_str();
  return option;
}

/// Refuses what is no decimal integer in [0, 2^64). CLI11's own conversion turns larger ones into 2^64 - 1.
CLI::Validator seed_check();

/// Refuses what is no number in [low, high], NaN included, which CLI::Range lets pass. The defaults are for limits of
/// time [s].
CLI::Validator number_check(double low = 1e-6, double high = 1e7);

/// --solved-at.
CLI::Option* add_solved_at(CLI::App& command, std::optional<double>& bound);

/// The solvers that are named, in canonical form. @throws InputError
std::vector<Spec> solver_specs(const std::vector<std::string>& texts);

/// How many threads run where the user names no number.
int processors();

/// Makes the folder that --out names, or one in it. @throws InputError, also where nothing can be written into it
void make_folder(const std::filesystem::path& folder);

/// @param inputs  files and names of problems, as "F.scenes#120"
/// @throws InputError where the file to write is one of those that the command reads
void refuse_inputs(const std::filesystem::path& out, const std::vector<std::string>& inputs);

/// Which problems of finite sets a study leaves out, for stderr; "" where none is.
std::string left_out_text(const Study& study);

/// Each declares one command with its options and help, and returns its action.
Action add_solvers_command(CLI::App& command);
Action add_steppers_command(CLI::App& command);
Action add_sets_command(CLI::App& command);
Action add_generate_command(CLI::App& command);
Action add_capture_command(CLI::App& command);
Action add_inspect_command(CLI::App& command);
Action add_audit_command(CLI::App& command);
Action add_dataset_command(CLI::App& command);
Action add_solve_command(CLI::App& command);
Action add_shrink_command(CLI::App& command);
Action add_models_command(CLI::App& command);
Action add_run_command(CLI::App& command);
Action add_merge_command(CLI::App& command);
Action add_replay_command(CLI::App& command);
Action add_view_command(CLI::App& command);
Action add_query_command(CLI::App& command);
Action add_report_command(CLI::App& command);
Action add_compare_command(CLI::App& command);
Action add_bench_command(CLI::App& command);
Action add_certify_command(CLI::App& command);
Action add_stability_command(CLI::App& command);
Action add_validate_command(CLI::App& command);

}  // namespace lcpbench
