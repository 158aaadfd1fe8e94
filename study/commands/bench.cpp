#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/isa.h"
#include "core/registry.h"
#include "generators/sets.h"
#include "study/commands/commands.h"
#include "study/commands/problem_files.h"
#include "study/evaluation/friction_model.h"
#include "study/output/columns.h"
#include "study/run/provenance.h"
#include "study/run/open_solver.h"
#include "study/run/study.h"
#include "study/statistics/statistics.h"

namespace lcpbench {
namespace {

struct BenchArguments {
  std::vector<std::string> sets{"paper/monotone/exp1", "paper/copositive/exp1"};
  std::vector<std::string> solvers{"lemke{engine=kernel}"};
  std::string reference = "lemke{engine=dense}";
  std::int64_t problems = 200;
  std::uint64_t seed = 1;
  double time_limit_s = 10.0;
  bool json = false;
};

struct Contender {
  SolverRow row;
  std::unique_ptr<TimedSolver> solver;
};

struct Measured {
  double time_s = 0;     ///< set-up and solve, thread CPU, mean of the rounds
  bool verified = true;  ///< the answer of every round
};

/// What solves the problems, contender 0 being the reference, and how.
struct Bench {
  std::vector<Contender> contenders;
  TimedRequest request;
  bool once = false;  ///< each problem is solved once, since a foreign program may remember it
  /// Set to non-zero from outside (a signal handler): no problem is begun any more.
  const volatile std::sig_atomic_t* stop = nullptr;
};

/// By contender: the mean time of all rounds, and whether each answer passes by the contender's own model of friction.
/// None where `stop` was raised.
std::vector<Measured> measure(const Problem& problem, Bench& bench, bool backwards) {
  Evaluator evaluator(problem);
  std::vector<Measured> measured(bench.contenders.size());
  std::vector<std::size_t> order(measured.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (backwards) std::reverse(order.begin(), order.end());
  const int rounds = bench.once ? 1 : 2;
  for (int round = 0; round < rounds; ++round) {
    for (const std::size_t i : order) {
      if (*bench.stop != 0) return {};
      TimedAnswer timed;
      bench.contenders[i].solver->run(problem, bench.request, timed);
      measured[i].time_s += (timed.times.setup_cpu_s + timed.times.solve_cpu_s) / rounds;
      Errors errors = evaluator.errors(timed.answer);
      measure_friction(friction_model(bench.contenders[i].row.friction, problem), problem, timed.answer, errors);
      measured[i].verified = measured[i].verified && errors.solved;
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

/// One solver against the reference on one set. Times are thread CPU time of set-up and solve together [s]: what it
/// takes from the problem's data to the answer.
Json cell_json(const std::string& set, const SolverRow& solver, std::int64_t problems, const Pairs& pairs) {
  const Estimate speedup = ratio_of_sums(pairs.reference, pairs.solver);
  LogSums ratios;
  for (std::size_t i = 0; i < pairs.solver.size(); ++i) ratios.add(std::log(pairs.reference[i] / pairs.solver[i]));
  return {{"set", set},
          {"solver", solver.name},
          {"settings", solver.settings},
          {"problems", problems},         // that were solved
          {"timed", pairs.solver.size()},  // on which this answer and the reference's were both verified
          {"speedup_mean", json_number(speedup.value)},
          {"speedup_geomean", json_number(ratios.geometric_mean().value)},
          {"speedup_low", json_number(speedup.low)},
          {"speedup_high", json_number(speedup.high)},
          {"reference_mean_s", json_number(spread(pairs.reference).mean)},
          {"solver_mean_s", json_number(spread(pairs.solver).mean)}};
}

/// Times solvers against the reference on a set, in one thread, interleaved problem by problem: the reference and all
/// solvers in order, then in reverse order, each the mean of its two times, so that drifts cancel. Both sides run at
/// the instruction-set level of this process. An answer counts as verified when it passes the evaluation, both times.
void bench_set(const std::string& name, const BenchArguments& arguments, Bench& bench, Json& cells) {
  const std::unique_ptr<ProblemSet> set = interruptibly([&] { return open_set(name); });
  const std::int64_t planned = std::min(arguments.problems, set->count().value_or(arguments.problems));
  std::vector<Pairs> pairs(bench.contenders.size());
  std::int64_t problems = 0;
  for (; problems < planned; ++problems) {
    const std::vector<Measured> measured =
        measure(set->generate(arguments.seed, problems), bench, problems % 2 == 1);
    if (measured.empty()) break;
    for (std::size_t i = 1; i < measured.size(); ++i) {
      if (!measured[0].verified || !measured[i].verified) continue;
      pairs[i].reference.push_back(measured[0].time_s);
      pairs[i].solver.push_back(measured[i].time_s);
    }
  }
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    cells.push_back(cell_json(set->name(), bench.contenders[i].row, problems, pairs[i]));
  }
}

std::string format_ratio(double ratio) { return std::isfinite(ratio) ? fmt::format("{:#.3g}x", ratio) : "-"; }

void print_cells(const Json& cells, const std::string& reference) {
  using Align = TextTable::Align;
  const auto timed = [](const Json& cell) { return cell["timed"].dump() + "/" + cell["problems"].dump(); };
  const auto interval = [](const Json& cell) {
    return field("speedup_low", format_ratio)(cell) + " .. " + field("speedup_high", format_ratio)(cell);
  };
  const std::vector<JsonColumn> columns{
      {{"set", Align::kLeft}, field("set")},
      {{"solver", Align::kLeft}, solver_text},
      {{"timed"}, timed},
      {{"reference", Align::kRight, 2}, field("reference_mean_s", format_seconds)},
      {{"solver", Align::kRight, 1}, field("solver_mean_s", format_seconds)},
      {{"speed-up"}, field("speedup_mean", format_ratio)},
      {{"95 % interval"}, interval},
      {{"geometric mean", Align::kRight, 3}, field("speedup_geomean", format_ratio)}};
  say(stdout, "{}\n", table_text(columns, cells));
  say_folded("reference {}, instruction set {}, thread CPU time of set-up and solve; timed: problems that both solved, "
             "verified; speed-up: ratio of summed times\n",
             reference, to_string(isa_level()));
}

int run_bench(const BenchArguments& arguments) {
  const Json origin = provenance(typed_command_line, utc_now());
  std::vector<std::string> names{arguments.reference};
  names.insert(names.end(), arguments.solvers.begin(), arguments.solvers.end());
  const std::vector<Spec> specs = solver_specs(names);
  Bench bench;
  bench.once = are_timed_once(specs);
  bench.request = {.time_limit_s = arguments.time_limit_s, .repeat_until_s = bench.once ? 0 : kRepeatUntilS};
  bench.stop = catch_interrupts(kExitInterrupted);
  for (const Spec& spec : specs) bench.contenders.push_back({solver_row(spec), open_solver(spec)});
  std::vector<std::string> sets;
  for (const std::string& pattern : arguments.sets) {
    for (std::string& name : expand_sets(pattern)) sets.push_back(std::move(name));
  }
  ProgressLine progress;
  Json cells = Json::array();
  for (const std::string& set : sets) {
    if (*bench.stop != 0) break;
    progress.begin("timing " + set);
    bench_set(set, arguments, bench, cells);
  }
  progress.clear();
  if (arguments.json) {
    print_json({{"provenance", origin},
                {"reference", arguments.reference},
                {"isa", to_string(isa_level())},
                {"cells", cells}});
  } else {
    print_cells(cells, arguments.reference);
  }
  return *bench.stop != 0 ? kExitInterrupted : kExitDone;
}

}  // namespace

Action add_bench_command(CLI::App& command) {
  const auto arguments = std::make_shared<BenchArguments>();
  add_repeatable(command, "--set", arguments->sets, "problem set or glob; may be repeated");
  add_repeatable(command, "--solver", arguments->solvers, "name{key=value,...}; may be repeated");
  command.add_option("--reference", arguments->reference, "what the solvers are compared to")->capture_default_str();
  add_number(command, "--problems", arguments->problems, "of each set",
             CLI::Range(INT64_C(1), INT64_C(100'000'000)));
  add_number(command, "--seed", arguments->seed, "stream of random problems", seed_check());
  add_number(command, "--time-limit", arguments->time_limit_s, "seconds for each solve", number_check());
  add_output_options(command, arguments->json);
  command.footer(
      "One thread, interleaved problem by problem, in alternating order, thread CPU time. Only problems on which "
      "both answers are verified are timed. LCPBENCH_ISA sets the instruction-set level, of both sides. Ctrl-C "
      "shows what is measured so far (exit code 3).");
  return [arguments] { return run_bench(*arguments); };
}

}  // namespace lcpbench
