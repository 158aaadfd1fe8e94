#pragma once

#include <functional>
#include <string>

#include <CLI/CLI.hpp>

namespace lcpbench {

/// Exit codes of the program.
inline constexpr int kExitDone = 0;
inline constexpr int kExitCheckFailed = 1;
inline constexpr int kExitBadInput = 2;
inline constexpr int kExitInterrupted = 3;

/// The command line as typed, for the provenance of results. main() sets it.
inline std::string typed_command_line;

/// What a command does once its arguments are parsed. @returns the exit code. @throws InputError
using Action = std::function<int()>;

/// Each declares one command with its options and help, and returns its action.
Action add_solvers_command(CLI::App& command);
Action add_steppers_command(CLI::App& command);
Action add_sets_command(CLI::App& command);
Action add_generate_command(CLI::App& command);
Action add_capture_command(CLI::App& command);
Action add_import_command(CLI::App& command);
Action add_inspect_command(CLI::App& command);
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
