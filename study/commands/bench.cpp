#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/isa.h"
#include "core/registry.h"
#include "study/commands/commands.h"
#include "study/commands/options.h"
#include "study/run/interrupt.h"
#include "study/output/json_output.h"
#include "study/run/provenance.h"
#include "study/commands/speed_bench.h"
#include "study/output/terminal.h"
#include "study/output/text_table.h"

namespace lcpbench {
namespace {

using Json = nlohmann::ordered_json;

struct Arguments {
  std::vector<std::string> sets{"paper/monotone/exp1", "paper/copositive/exp1"};
  std::vector<std::string> solvers{"lemke{engine=kernel}"};
  std::string reference = "lemke{engine=dense}";
  std::int64_t problems = 200;
  std::uint64_t seed = 1;
  double time_limit_s = 10.0;
  std::string format = "text";
  Extent extent;
  std::string command_line;
};

Spec checked_spec(const std::string& text) { return canonical_solver_spec(parse_spec(text)); }

Json cells_json(const std::vector<BenchCell>& cells) {
  Json array = Json::array();
  for (const BenchCell& cell : cells) {
    array.push_back({{"set", cell.set},
                     {"solver", cell.solver.name},
                     {"settings", cell.solver.settings},
                     {"problems", cell.problems},
                     {"timed", cell.timed},
                     {"speedup_mean", json_number(cell.speedup_mean)},
                     {"speedup_geomean", json_number(cell.speedup_geomean)},
                     {"speedup_low", json_number(cell.speedup_low)},
                     {"speedup_high", json_number(cell.speedup_high)},
                     {"reference_mean_s", json_number(cell.reference_mean_s)},
                     {"solver_mean_s", json_number(cell.solver_mean_s)}});
  }
  return array;
}

std::string format_ratio(double ratio) { return std::isfinite(ratio) ? fmt::format("{:#.3g}x", ratio) : "-"; }

void print_cells(const std::vector<BenchCell>& cells, const Spec& reference, int width) {
  using Align = TextTable::Align;
  TextTable table({{"set", Align::kLeft},
                   {"solver", Align::kLeft},
                   {"timed"},
                   {"reference", Align::kRight, 2},
                   {"solver", Align::kRight, 1},
                   {"speed-up"},
                   {"95 % interval"},
                   {"geometric mean", Align::kRight, 3}});
  for (const BenchCell& cell : cells) {
    table.add_row({cell.set, cell.solver.text(), fmt::format("{}/{}", cell.timed, cell.problems),
                   format_seconds(cell.reference_mean_s), format_seconds(cell.solver_mean_s),
                   format_ratio(cell.speedup_mean),
                   fmt::format("{} .. {}", format_ratio(cell.speedup_low), format_ratio(cell.speedup_high)),
                   format_ratio(cell.speedup_geomean)});
  }
  say(stdout, "{}\n{}", table.text(width),
      folded(fmt::format("reference {}, instruction set {}, thread CPU time of set-up and solve; timed: problems that "
                         "both solved, verified; speed-up: ratio of summed times\n",
                         reference.text(), to_string(isa_level())),
             width));
}

int bench(const Arguments& arguments) {
  const Json origin = provenance(arguments.command_line, utc_now());
  BenchPlan plan;
  plan.sets = arguments.sets;
  for (const std::string& solver : arguments.solvers) plan.solvers.push_back(checked_spec(solver));
  plan.reference = checked_spec(arguments.reference);
  plan.problems = arguments.problems;
  plan.seed = arguments.seed;
  plan.time_limit_s = arguments.time_limit_s;
  plan.stop = catch_interrupts(kExitInterrupted);
  ProgressLine progress;
  const std::vector<BenchCell> cells =
      run_bench(plan, [&](const std::string& set) { progress.begin("timing " + set); });
  progress.clear();
  if (arguments.format == "json") {
    print_json({{"provenance", origin},
                {"reference", arguments.reference},
                {"isa", to_string(isa_level())},
                {"cells", cells_json(cells)}});
  } else {
    print_cells(cells, parse_spec(arguments.reference), arguments.extent.width());
  }
  return *plan.stop != 0 ? kExitInterrupted : kExitDone;
}

}  // namespace

Action add_bench_command(CLI::App& command, const std::string& command_line) {
  const auto arguments = std::make_shared<Arguments>();
  arguments->command_line = command_line;
  command.add_option("--set", arguments->sets, "problem set or glob; may be repeated")
      ->allow_extra_args(false)
      ->capture_default_str();
  command.add_option("--solver", arguments->solvers, "name{key=value,...}; may be repeated")
      ->allow_extra_args(false)
      ->capture_default_str();
  command.add_option("--reference", arguments->reference, "what the solvers are compared to")->capture_default_str();
  command.add_option("--problems", arguments->problems, "of each set")
      ->check(CLI::Range(INT64_C(1), INT64_C(100'000'000)))
      ->capture_default_str();
  command.add_option("--seed", arguments->seed, "stream of random problems")
      ->check(seed_check())
      ->capture_default_str();
  command.add_option("--time-limit", arguments->time_limit_s, "seconds for each solve")
      ->check(seconds_check(1e-6, 1e7))
      ->capture_default_str();
  add_wide_option(command, arguments->extent);
  add_format_option(command, arguments->format);
  command.footer(
      "One thread, interleaved problem by problem, in alternating order, thread CPU time. Only problems on which "
      "both answers are verified are timed. LCPBENCH_ISA sets the instruction-set level, of both sides. Ctrl-C "
      "shows what is measured so far (exit code 3).");
  return [arguments] { return bench(*arguments); };
}

}  // namespace lcpbench
