// How `auto` does on frictional problems that are given as (q, M), beside a solver that it has to be as good as: one
// CSV row for each set. Not a test; docs/reference/solvers/auto.md has the command.
//
//   bare_frictional TRIALS SEED [--other SOLVER] [--time-limit SECONDS] [SET...]
//
// Without sets: every frictional experiment of the paper, exp2 to exp5 in both readings of redundancy. q and M are
// those of form_lcp(). Solved is the verdict (backward error of (q, M)) of an answer that is claimed. Times are of load
// and solve together, in seconds of CPU over all problems, the two solvers taking turns; of each the faster of two runs
// counts.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/registry.h"
#include "core/spec.h"
#include "core/timed_solve.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {
namespace {

struct Plan {
  std::int64_t trials = 0;
  std::uint64_t seed = 0;
  std::string other = "lemke";
  double time_limit_s = 10;
};

std::vector<std::string> paper_sets() {
  std::vector<std::string> sets{"paper/copositive/exp1"};
  for (const char* name : {"exp2", "exp3", "exp4", "exp5-1e5", "exp5-1e8", "exp5-1e10"}) {
    for (const char* reading : {"", "{redundancy=combination}"}) {
      // Those without redundant contacts have no readings of them.
      const std::string set = std::string("paper/copositive/") + name + reading;
      try {
        open_set(set);
      } catch (const InputError&) {
        continue;
      }
      sets.push_back(set);
    }
  }
  return sets;
}

/// What became of the problems of a set by one solver.
struct Tally {
  int claimed = 0, solved = 0, false_claims = 0, unsolvable = 0;
  double time_s = 0, longest_s = 0;
};

struct Run {
  bool solved = false;
  double time_s = 0;
};

Run run(const Spec& spec, const Problem& problem, Evaluator& evaluator, double time_limit_s, Tally& tally) {
  constexpr int kRuns = 2;
  Answer answer;
  Run result{.time_s = time_limit_s * kRuns};
  for (int k = 0; k < kRuns; ++k) {
    const std::unique_ptr<Solver> solver = make_solver(spec);
    answer = {};
    const double start_s = thread_cpu_clock_s();
    solver->load(problem);
    solver->solve({.time_limit_s = time_limit_s}, answer);
    result.time_s = std::min(result.time_s, thread_cpu_clock_s() - start_s);
  }
  const bool claimed = answer.claim == Claim::kSolved;
  result.solved = claimed && evaluator.errors(answer).solved;
  tally.claimed += claimed;
  tally.solved += result.solved;
  tally.false_claims += claimed && !result.solved;
  tally.unsolvable += answer.claim == Claim::kUnsolvable;
  tally.time_s += result.time_s;
  tally.longest_s = std::max(tally.longest_s, result.time_s);
  return result;
}

void measure(const Plan& plan, const std::string& name) {
  const std::unique_ptr<ProblemSet> set = open_set(name);
  const Spec own = parse_spec("auto");
  const Spec other = parse_spec(plan.other);
  Tally of_auto, of_other;
  int missed = 0;
  for (std::int64_t trial = 0; trial < plan.trials; ++trial) {
    const Problem contacts = set->generate(plan.seed, trial);
    const Problem problem(contacts.name(), form_lcp(*contacts.contact()));
    Evaluator evaluator(problem);
    const Run theirs = run(other, problem, evaluator, plan.time_limit_s, of_other);
    const Run ours = run(own, problem, evaluator, plan.time_limit_s, of_auto);
    if (!theirs.solved || ours.solved) continue;
    ++missed;
    std::fprintf(stderr, "%s seed %llu trial %lld (n = %lld): %s solves it, auto does not\n", name.c_str(),
                 static_cast<unsigned long long>(plan.seed), static_cast<long long>(trial),
                 static_cast<long long>(problem.size()), plan.other.c_str());
  }
  std::printf("\"%s\",%llu,%lld", name.c_str(), static_cast<unsigned long long>(plan.seed),
              static_cast<long long>(plan.trials));
  for (const Tally& tally : {of_auto, of_other}) {
    std::printf(",%d,%d,%d,%.4f,%.4f", tally.solved, tally.false_claims, tally.unsolvable, tally.time_s,
                tally.longest_s);
  }
  std::printf(",%d,%.3f\n", missed, of_auto.time_s / of_other.time_s);
  std::fflush(stdout);
}

int main_of(const std::vector<std::string>& arguments) {
  Plan plan;
  std::vector<std::string> sets;
  if (arguments.size() < 2) {
    std::fprintf(stderr, "bare_frictional TRIALS SEED [--other SOLVER] [--time-limit SECONDS] [SET...]\n");
    return 2;
  }
  plan.trials = std::atoll(arguments[0].c_str());
  plan.seed = std::strtoull(arguments[1].c_str(), nullptr, 10);
  for (std::size_t i = 2; i < arguments.size(); ++i) {
    if (arguments[i] == "--other" && i + 1 < arguments.size()) {
      plan.other = arguments[++i];
    } else if (arguments[i] == "--time-limit" && i + 1 < arguments.size()) {
      plan.time_limit_s = std::atof(arguments[++i].c_str());
    } else {
      sets.push_back(arguments[i]);
    }
  }
  if (sets.empty()) sets = paper_sets();
  std::printf("set,seed,problems");
  for (const char* solver : {"auto", "other"}) {
    for (const char* column : {"solved", "false_claims", "unsolvable", "time_s", "longest_s"}) {
      std::printf(",%s_%s", solver, column);
    }
  }
  std::printf(",only_other_solved,time_ratio\n");
  for (const std::string& set : sets) measure(plan, set);
  return 0;
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  try {
    return lcpbench::main_of({argv + 1, argv + argc});
  } catch (const lcpbench::InputError& error) {
    std::fprintf(stderr, "bare_frictional: %s\n", error.what());
    return 2;
  }
}
