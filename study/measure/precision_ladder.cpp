// Speed against error of the rungs of a direct method: one CSV row for each set and value of its setting `precision`.
// Not a test; results/native/README.md has its commands.
//
//   precision_ladder SOLVER TRIALS SEED SET...
//
// Times: mean of set-up and solve, thread CPU, the rungs of a problem one after the other, over all trials whatever
// their claim. Velocity errors are measured on frictionless sets, where v* is unique: computed in 113-bit arithmetic
// from the contacts that an answer of any rung presses, and proven by its signs (study/measure/exact_velocity.h); `proven`
// counts the claimed trials to which they belong. A rung that returns no velocity is measured by v + G* J f of its
// impulses, formed in double. rho is the relative velocity residual of z.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"
#include "study/measure/exact_velocity.h"

namespace lcpbench {
namespace {

struct Rung {
  std::string precision;
  std::unique_ptr<Solver> solver;
  TimedAnswer result;
  int claimed = 0, solved = 0, false_claims = 0;
  double time_s = 0;
  std::vector<double> rhos, errors;
};

double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return Errors::kNone;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

std::vector<Rung> rungs_of(const std::string& solver) {
  std::vector<Rung> rungs;
  for (const SettingInfo& setting : find_solver(solver).definition.settings()) {
    if (setting.name != "precision") continue;
    for (std::size_t begin = 0; begin <= setting.range.size();) {
      const std::size_t end = std::min(setting.range.find('|', begin), setting.range.size());
      Rung& rung = rungs.emplace_back();
      rung.precision = setting.range.substr(begin, end - begin);
      rung.solver = make_solver({solver, {{"precision", rung.precision}}});
      begin = end + 1;
    }
  }
  return rungs;
}

void add(const Problem& problem, std::vector<Rung>& rungs) {
  Evaluator evaluator(problem);
  QuadVector exact;
  bool proven = false;
  for (Rung& rung : rungs) {
    timed_solve(*rung.solver, problem, {.repeat_until_s = 2e-4}, rung.result);
    const Answer& answer = rung.result.answer;
    const Errors errors = evaluator.errors(answer);
    const bool claims = answer.claim == Claim::kSolved;
    rung.time_s += rung.result.times.setup_cpu_s + rung.result.times.solve_cpu_s;
    rung.claimed += claims;
    rung.solved += errors.solved;
    rung.false_claims += claims && !errors.solved;
    if (claims) rung.rhos.push_back(errors.velocity_residual_relative);
    if (claims && !proven && !problem.contact()->frictional()) {
      proven = testing::exact_velocity(*problem.contact(), answer.z, exact);
    }
  }
  for (Rung& rung : rungs) {
    const Answer& answer = rung.result.answer;
    if (!proven || answer.claim != Claim::kSolved) continue;
    const Vector velocity =
        answer.velocity.size() > 0 ? Vector(answer.velocity) : post_impact_velocity(*problem.contact(), answer.z);
    rung.errors.push_back(testing::velocity_error(*problem.contact(), velocity, exact));
  }
}

void measure(const std::string& solver, const ProblemSet& set, int trials, std::uint64_t seed) {
  std::vector<Rung> rungs = rungs_of(solver);
  for (int trial = 0; trial < trials; ++trial) add(set.generate(seed, trial), rungs);
  for (Rung& rung : rungs) {
    std::printf("\"%s\",%s,%s,%d,%d,%d,%d,%.3g,%.2g,%.2g,%zu,%.2g,%.2g,%.2g\n", set.name().c_str(), solver.c_str(),
                rung.precision.c_str(), trials, rung.claimed, rung.solved, rung.false_claims,
                1e6 * rung.time_s / trials, quantile(rung.rhos, 0.5), quantile(rung.rhos, 0.99), rung.errors.size(),
                quantile(rung.errors, 0.5), quantile(rung.errors, 0.99), quantile(rung.errors, 1));
  }
  std::fflush(stdout);
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  if (argc < 5) {
    std::fprintf(stderr, "precision_ladder SOLVER TRIALS SEED SET...\n");
    return 2;
  }
  std::printf(
      "set,solver,precision,trials,claimed,solved,false_claims,time_us,rho_median,rho_p99,proven,error_median,error_"
      "p99,"
      "error_max\n");
  for (int i = 4; i < argc; ++i) {
    const auto set = lcpbench::open_set(argv[i]);
    lcpbench::measure(argv[1], *set, std::atoi(argv[2]), std::strtoull(argv[3], nullptr, 10));
  }
}
