// How exact active_set is: one CSV row for each set and rung. Not a test; results/native/README.md has its command.
//
//   active_set_accuracy TRIALS SEED SET...
//
// v* is computed in 113-bit arithmetic from the contacts that the answer presses, and proven by its signs
// (study/measure/exact_velocity.h); `proven` counts the trials where that succeeded, to which the errors belong.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/registry.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"
#include "study/measure/exact_velocity.h"

namespace lcpbench {
SolverDefinition lcpbench_solver_active_set();

namespace {

double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return Errors::kNone;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

void measure(const ProblemSet& set, const std::string& precision, int trials, std::uint64_t seed) {
  const auto solver = lcpbench_solver_active_set().make({{"precision", precision}});
  std::vector<double> errors;
  int claimed = 0, solved = 0, false_claims = 0, solved_1e6 = 0, solved_1e9 = 0, climbed = 0;
  std::int64_t steps = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const Problem problem = set.generate(seed, trial);
    Answer answer;
    solver->load(problem);
    solver->solve({}, answer);
    const Errors measured = Evaluator(problem).errors(answer);
    claimed += answer.claim == Claim::kSolved;
    solved += measured.solved;
    false_claims += answer.claim == Claim::kSolved && !measured.solved;
    solved_1e6 += measured.velocity_residual_relative <= 1e-6;
    solved_1e9 += measured.velocity_residual_relative <= 1e-9;
    climbed += answer.detail.ends_with("rung");
    steps += answer.counters.pivots;
    QuadVector exact;
    if (answer.claim != Claim::kSolved || answer.velocity.size() == 0) continue;
    if (!testing::exact_velocity(*problem.contact(), answer.z, exact)) continue;
    errors.push_back(testing::velocity_error(*problem.contact(), answer.velocity, exact));
  }
  std::printf("\"%s\",%s,%d,%d,%d,%d,%d,%d,%d,%zu,%.2f,%.2g,%.2g,%.2g\n", set.name().c_str(), precision.c_str(), trials,
              claimed, solved, false_claims, solved_1e6, solved_1e9, climbed, errors.size(),
              static_cast<double>(steps) / trials, quantile(errors, 0.5), quantile(errors, 0.99), quantile(errors, 1));
  std::fflush(stdout);
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "active_set_accuracy TRIALS SEED SET...\n");
    return 2;
  }
  std::printf(
      "set,precision,trials,claimed,solved,false_claims,solved_1e6,solved_1e9,quad_rung,proven,steps,error_median,"
      "error_p99,error_max\n");
  for (int i = 3; i < argc; ++i) {
    const auto set = lcpbench::open_set(argv[i]);
    for (const char* precision : {"double", "ladder"}) {
      lcpbench::measure(*set, precision, std::atoi(argv[1]), std::strtoull(argv[2], nullptr, 10));
    }
  }
}
