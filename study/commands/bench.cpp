#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/isa.h"
#include "core/registry.h"
#include "generators/sets.h"
#include "study/commands/commands.h"
#include "study/commands/options.h"
#include "study/commands/problem_files.h"
#include "study/evaluation/evaluation.h"
#include "study/run/interrupt.h"
#include "study/output/json_output.h"
#include "study/run/provenance.h"
#include "study/output/terminal.h"
#include "study/output/text_table.h"
#include "study/run/open_solver.h"
#include "study/run/study.h"
#include "study/statistics/statistics.h"

namespace lcpbench {
namespace {

using Json = nlohmann::ordered_json;

struct BenchArguments {
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

struct BenchPlan {
  std::vector<std::string> sets;  ///< names or globs
  std::vector<Spec> solvers;
  Spec reference;
  std::int64_t problems = 200;  ///< of each set
  std::uint64_t seed = 1;
  double time_limit_s = 10.0;
  double repeat_until_s = 2e-4;
  /// Set to non-zero from outside (a signal handler): no problem is begun any more.
  const volatile std::sig_atomic_t* stop = nullptr;

  bool is_timed_once() const { return are_timed_once(solvers) || are_timed_once({reference}); }
};

/// One solver against the reference on one set. Times are thread CPU time of set-up and solve together [s]: what it
/// takes from the problem's data to the answer. NaN where no problem was timed.
struct BenchCell {
  std::string set;
  SolverRow solver;
  std::int64_t problems = 0;  ///< that were solved
  std::int64_t timed = 0;     ///< problems on which this answer and the reference's were both verified
  double speedup_mean = 0;    ///< summed time of the reference / summed time of the solver
  double speedup_low = 0;     ///< 95 % interval of it over problems
  double speedup_high = 0;
  double speedup_geomean = 0;  ///< geometric mean of the ratios
  double reference_mean_s = 0;
  double solver_mean_s = 0;
};

struct Contender {
  SolverRow row;
  std::unique_ptr<TimedSolver> solver;
};

struct Measured {
  double time_s = 0;  ///< sum over the rounds so far
  bool verified = true;
};

double cpu_time_s(const SolveTimes& times) { return times.setup_cpu_s + times.solve_cpu_s; }

bool stopped(const BenchPlan& plan) { return plan.stop != nullptr && *plan.stop != 0; }

/// Contender 0 is the reference. None where `stop` was raised.
std::vector<Measured> measure(const Problem& problem, std::vector<Contender>& contenders, const BenchPlan& plan,
                              bool backwards) {
  TimedRequest request;
  request.time_limit_s = plan.time_limit_s;
  const bool once = plan.is_timed_once();
  request.repeat_until_s = once ? 0 : plan.repeat_until_s;
  Evaluator evaluator(problem);
  std::vector<Measured> measured(contenders.size());
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < contenders.size(); ++i) order.push_back(i);
  if (backwards) std::reverse(order.begin(), order.end());
  const int rounds = once ? 1 : 2;
  for (int round = 0; round < rounds; ++round) {
    for (const std::size_t i : order) {
      if (stopped(plan)) return {};
      TimedAnswer timed;
      contenders[i].solver->run(problem, request, timed);
      measured[i].time_s += cpu_time_s(timed.times) / rounds;
      measured[i].verified = measured[i].verified && evaluator.errors(timed.answer).solved;
    }
    std::reverse(order.begin(), order.end());
  }
  return measured;
}

/// Times of the problems that count, in pairs.
struct Pairs {
  std::vector<double> reference;
  std::vector<double> solver;
};

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double geometric_mean_ratio(const Pairs& pairs) {
  double sum = 0;
  for (std::size_t i = 0; i < pairs.solver.size(); ++i) sum += std::log(pairs.reference[i] / pairs.solver[i]);
  return std::exp(sum / static_cast<double>(pairs.solver.size()));
}

BenchCell summarise(const std::string& set, const SolverRow& solver, std::int64_t problems, const Pairs& pairs) {
  const Estimate speedup = ratio_of_sums(pairs.reference, pairs.solver);
  return {.set = set,
          .solver = solver,
          .problems = problems,
          .timed = static_cast<std::int64_t>(pairs.solver.size()),
          .speedup_mean = speedup.value,
          .speedup_low = speedup.low,
          .speedup_high = speedup.high,
          .speedup_geomean = geometric_mean_ratio(pairs),
          .reference_mean_s = mean(pairs.reference),
          .solver_mean_s = mean(pairs.solver)};
}

std::vector<BenchCell> bench_set(const std::string& name, const BenchPlan& plan, std::vector<Contender>& contenders) {
  const std::unique_ptr<ProblemSet> set = interruptibly([&] { return open_set(name); });
  const std::int64_t planned = std::min(plan.problems, set->count().value_or(plan.problems));
  std::vector<Pairs> pairs(contenders.size());
  std::int64_t problems = 0;
  for (; problems < planned; ++problems) {
    const std::vector<Measured> measured = measure(set->generate(plan.seed, problems), contenders, plan, problems % 2 == 1);
    if (measured.empty()) break;
    for (std::size_t i = 1; i < contenders.size(); ++i) {
      if (!measured[0].verified || !measured[i].verified) continue;
      pairs[i].reference.push_back(measured[0].time_s);
      pairs[i].solver.push_back(measured[i].time_s);
    }
  }
  std::vector<BenchCell> cells;
  for (std::size_t i = 1; i < contenders.size(); ++i) {
    cells.push_back(summarise(set->name(), contenders[i].row, problems, pairs[i]));
  }
  return cells;
}

/// Times solvers against the reference, in one thread, interleaved problem by problem: the reference and all solvers in
/// order, then in reverse order, each the mean of its two times, so that drifts cancel. Both sides run at the
/// instruction-set level of this process. An answer counts as verified when its verdict is solved, both times.
/// @param on_set called with each set's name before it is run
/// @returns the cells of every set that was begun, each with the problems that were solved until `stop`
/// @throws InputError for unknown sets and solvers that are not available.
std::vector<BenchCell> run_bench(const BenchPlan& plan, const std::function<void(const std::string&)>& on_set) {
  std::vector<Contender> contenders;
  contenders.push_back({solver_row(plan.reference), open_solver(plan.reference)});
  for (const Spec& solver : plan.solvers) contenders.push_back({solver_row(solver), open_solver(solver)});
  std::vector<std::string> sets;
  for (const std::string& pattern : plan.sets) {
    for (std::string& name : expand_sets(pattern)) sets.push_back(std::move(name));
  }
  std::vector<BenchCell> cells;
  for (const std::string& set : sets) {
    if (stopped(plan)) break;
    on_set(set);
    for (BenchCell& cell : bench_set(set, plan, contenders)) cells.push_back(std::move(cell));
  }
  return cells;
}

// ------------------------------------------------------------------------------------------------------ output

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

int bench(const BenchArguments& arguments) {
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
  const auto arguments = std::make_shared<BenchArguments>();
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
