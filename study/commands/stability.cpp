#include "study/stability/stability.h"

#include "study/commands/commands.h"
#include "study/run/open_solver.h"
#include "study/run/plan.h"
#include "study/run/provenance.h"
#include "study/stability/stability_output.h"

namespace lcpbench {
namespace {

struct StabilityArguments {
  std::vector<std::string> sets{"hard/*",
                                "paper/monotone/exp1",
                                "paper/monotone/exp2",
                                "paper/monotone/exp3",
                                "paper/monotone/exp5-1e8",
                                "paper/monotone/exp5-1e10",
                                "paper/copositive/exp1",
                                "rigid/exp1{nc_max=8}",
                                "planted/definite"};
  std::vector<std::string> solvers;
  std::int64_t trials = 10;
  std::uint64_t seed = 1;
  double time_limit_s = 1.0;
  bool all = false;
  bool json = false;
};

Plan make_plan(const StabilityArguments& arguments) {
  Plan plan;
  plan.name = "stability";
  plan.trials = arguments.trials;
  plan.seed = arguments.seed;
  plan.time_limit_s = arguments.time_limit_s;
  for (const std::string& set : arguments.sets) plan.sets.push_back({.pattern = set});
  std::vector<std::string> solvers = arguments.solvers;
  for (const RegisteredSolver& solver : registered_solvers()) {
    if (arguments.solvers.empty() && runs_unasked(solver)) solvers.push_back(solver.definition.name);
  }
  for (const Spec& spec : solver_specs(solvers)) plan.solvers.push_back({.spec = spec});
  return plan;
}

int run_stability(const StabilityArguments& arguments) {
  const Json origin = provenance(typed_command_line, utc_now());
  const Study study = resolve(make_plan(arguments));
  say(stderr, "{}", left_out_text(study));
  StabilityOptions options;
  options.seed = arguments.seed;
  options.time_limit_s = arguments.time_limit_s;
  options.stop = catch_interrupts(kExitInterrupted);
  ProgressLine progress;
  options.on_set = [&progress](const std::string& set) { progress.begin("solving " + set); };
  const StabilityResult result = stability(study.sets, study.solvers, options);
  progress.clear();
  if (arguments.json) {
    print_json({{"provenance", origin},
                {"sets", result.sets},
                {"problems", result.problems},
                {"left_out", result.left_out},
                {"allowed_amplification", kAllowedAmplification},
                {"cells", stability_json(result)}});
  } else {
    say(stdout, "{}", stability_text(result, arguments.all, text_width()));
  }
  return *options.stop != 0 ? kExitInterrupted : kExitDone;
}

}  // namespace

Action add_stability_command(CLI::App& command) {
  const auto arguments = std::make_shared<StabilityArguments>();
  add_repeatable(command, "--set", arguments->sets, "problem set or glob; may be repeated");
  add_repeatable(command, "--solver", arguments->solvers,
                 "name{key=value,...}; may be repeated (default: every available one that needs no setting and no "
                 "captured step)");
  add_number(command, "--trials", arguments->trials, "problems of each set",
             CLI::Range(INT64_C(1), INT64_C(1'000'000)));
  add_number(command, "--seed", arguments->seed, "stream of random problems and of changes", seed_check());
  add_number(command, "--time-limit", arguments->time_limit_s, "seconds for each solve", number_check(1e-3, 1e6));
  command.add_flag("--long", arguments->all, "show every solver and change");
  add_output_options(command, arguments->json);
  command.footer(
      "Each problem of SET is solved, and the problems that the sets changed{of=SET,by=...} make of it: scaled, in "
      "other units and orders, with a contact twice, with other last digits. The physical answer must move no more "
      "than conditioning allows. One thread. Ctrl-C shows what is known so far (exit code 3). See "
      "docs/howto/compare.md.");
  return [arguments] { return run_stability(*arguments); };
}

}  // namespace lcpbench
