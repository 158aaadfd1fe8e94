// What compliance costs each solver: the time of soft contacts over that of the same contacts made hard, by set. Not a
// test; results/soft/README.md has its commands.
//
//   softness SHARE ROUNDS SOLVER... -- SET[*]...
//
// Compliance is SHARE times M_nn along the normal and both tangents of each contact. With SHARE = 0 it is that of the
// set, and the hard contacts are those without it and without tangential offsets. Thread CPU time of load and solve,
// the least of the rounds, in which soft and hard contacts and the solvers take turns; what is short is repeated for 2
// ms. The same with the rigid equivalent of the soft contacts in their place. Only problems that count in both ways:
// both answers are claimed, and solved by the evaluation unless the solver has another model of friction (cone=true).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/compliance.h"
#include "core/error.h"
#include "core/exact_inertia.h"
#include "core/timed_solve.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"
#include "study/run/open_solver.h"

namespace lcpbench {
namespace {

/// @returns the soft contacts, the hard ones, and the rigid equivalent of the soft ones
std::array<Problem, 3> all_ways(const Problem& given, double share) {
  ContactProblem soft = *given.contact(), hard = soft;
  hard.compliance_n = hard.compliance_t = hard.offset_t = Vector();
  if (share > 0) {
    const Matrix N = to_dense(soft.N);
    soft.compliance_n = share * (N.transpose() * inverse_inertia(soft.inertia) * N).diagonal();
    soft.compliance_t = soft.compliance_n;
    for (Index c = 0; c < soft.nc(); ++c) {
      if (soft.edges[static_cast<std::size_t>(c)] == 0) soft.compliance_t(c) = 0;
    }
  }
  ContactProblem rigid = rigid_equivalent(soft);
  return {Problem("soft", std::move(soft)), Problem("hard", std::move(hard)), Problem("rigid", std::move(rigid))};
}

struct Measured {
  double least_s = INFINITY;
  bool is_solved = false;
};

void measure(const Problem& problem, TimedSolver& solver, bool is_judged, Measured& to) {
  TimedAnswer result;
  solver.run(problem, {.time_limit_s = 10, .repeat_until_s = 2e-3}, result);
  to.least_s = std::min(to.least_s, result.times.setup_cpu_s + result.times.solve_cpu_s);
  to.is_solved = result.answer.claim == Claim::kSolved;
  if (is_judged) to.is_solved = to.is_solved && Evaluator(problem).errors(result.answer).solved;
}

void measure_set(const std::string& name, double share, int rounds, const std::vector<std::string>& names) {
  std::vector<std::unique_ptr<TimedSolver>> solvers;
  for (const std::string& solver : names) solvers.push_back(open_solver(parse_spec(solver)));
  const auto set = open_set(name);
  struct Sum {
    double ratio = 0, ratio_rigid = 0;
    int both = 0, soft = 0, hard = 0;
  };
  std::vector<Sum> sums(names.size());
  const std::int64_t count = set->count().value_or(100);
  for (std::int64_t trial = 0; trial < count; ++trial) {
    const std::array<Problem, 3> problems = all_ways(set->generate(1, trial), share);
    std::vector<std::array<Measured, 3>> measured(names.size());
    for (int round = 0; round < rounds; ++round) {
      for (std::size_t s = 0; s < names.size(); ++s) {
        const bool is_judged = names[s].find("cone=true") == std::string::npos;
        for (std::size_t way : {0, 1, 2}) measure(problems[way], *solvers[s], is_judged, measured[s][way]);
      }
    }
    for (std::size_t s = 0; s < names.size(); ++s) {
      const auto& [soft, hard, rigid] = measured[s];
      sums[s].soft += soft.is_solved ? 1 : 0;
      sums[s].hard += hard.is_solved ? 1 : 0;
      if (!soft.is_solved || !hard.is_solved) continue;
      ++sums[s].both;
      sums[s].ratio += soft.least_s / hard.least_s;
      sums[s].ratio_rigid += rigid.least_s / hard.least_s;
    }
  }
  for (std::size_t s = 0; s < names.size(); ++s) {
    std::printf("%s,%s,%g,%lld,%d,%d,%d,%.3f,%.3f\n", name.c_str(), names[s].c_str(), share,
                static_cast<long long>(count), sums[s].soft, sums[s].hard, sums[s].both, sums[s].ratio / sums[s].both,
                sums[s].ratio_rigid / sums[s].both);
  }
  std::fflush(stdout);
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + std::min(argc, 3), argv + argc);
  const auto end = std::find(words.begin(), words.end(), "--");
  if (argc < 5 || end == words.end()) {
    std::fprintf(stderr, "softness SHARE ROUNDS SOLVER... -- SET...\n");
    return 2;
  }
  std::puts("set,solver,share,problems,soft_solved,hard_solved,both,mean_ratio,mean_ratio_rigid_equivalent");
  try {
    for (auto set = end + 1; set != words.end(); ++set) {
      for (const std::string& each : lcpbench::expand_sets(*set)) {
        lcpbench::measure_set(each, std::atof(argv[1]), std::atoi(argv[2]), {words.begin(), end});
      }
    }
  } catch (const lcpbench::InputError& error) {
    std::fprintf(stderr, "softness: %s\n", error.what());
    return 2;
  }
}
