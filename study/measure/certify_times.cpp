// What certificates cost and prove: one CSV row for each set. Not a test; results/certify/README.md has its command.
//
//   certify_times TRIALS SEED SET...
//
// Columns: kinds of certificates; the upper end of Wilson's 95 % interval for the open share; milliseconds of CPU time
// of certify(), fallbacks included (`small_mean_ms`: of the problems with n <= 150); and what speaks against the
// certificates: `disproofs`, certified solutions where another solver's contradiction was exactly checked; `answers`,
// proofs of unsolvability where another solver's answer has rho <= 1e-9; `roundings`, certified z that, rounded to
// doubles, are no longer verified (rho <= 1e-4).

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "generators/sets.h"
#include "study/certify/certificate.h"
#include "study/evaluation/evaluation.h"
#include "study/statistics/statistics.h"

namespace lcpbench {
namespace {

constexpr Index kSmall = 150;

struct Row {
  int exact_basis = 0;
  int by_lp = 0;
  int farkas = 0;
  int branched = 0;
  int open = 0;
  int other_velocity = 0;
  int disproofs = 0;
  int answers = 0;
  int roundings = 0;
  std::vector<double> milliseconds;
  std::vector<double> small_milliseconds;
};

void count(const Certificate& certificate, Row& row) {
  row.open += certificate.kind == CertificateKind::kOpen;
  row.exact_basis += certificate.proof == ProofKind::kExactBasis;
  row.by_lp += certificate.proof == ProofKind::kLp;
  row.farkas += certificate.proof == ProofKind::kFarkas;
  row.branched += certificate.proof == ProofKind::kBranching;
  row.other_velocity += certificate.velocity_unique == false;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

void compare(const Problem& problem, const Certificate& certificate, Solver& solver, Row& row) {
  Evaluator evaluator(problem);
  Answer answer;
  solver.load(problem);
  solver.solve({}, answer);
  const bool unsolvable = certificate.kind == CertificateKind::kUnsolvable;
  row.disproofs += !unsolvable && answer.farkas.size() > 0 && evaluator.check_farkas(answer.farkas);
  row.answers += unsolvable && evaluator.errors(answer).velocity_residual_relative <= 1e-9;
  if (certificate.proof != ProofKind::kExactBasis) return;
  answer.z = certificate.z;
  row.roundings += !evaluator.errors(answer).solved;
}

void measure(const std::string& name, int trials, std::uint64_t seed) {
  const std::unique_ptr<ProblemSet> set = open_set(name);
  const bool monotone = name.find("monotone") != std::string::npos;
  const std::unique_ptr<Solver> other = make_solver({monotone ? "active_set" : "contact_lemke", {}});
  Certifier certifier({});
  Row row;
  for (int trial = 0; trial < trials; ++trial) {
    const Problem problem = set->generate(seed, trial);
    const double begin_s = thread_cpu_clock_s();
    const Certificate certificate = certifier.certify(problem);
    row.milliseconds.push_back(1e3 * (thread_cpu_clock_s() - begin_s));
    if (problem.size() <= kSmall) row.small_milliseconds.push_back(row.milliseconds.back());
    count(certificate, row);
    compare(problem, certificate, *other, row);
  }
  std::sort(row.milliseconds.begin(), row.milliseconds.end());
  std::printf("\"%s\",%d,%d,%d,%d,%d,%d,%.4f,%d,%.3f,%.3f,%.3f,%.3f,%.3f,%d,%d,%d\n", set->name().c_str(), trials,
              row.exact_basis, row.by_lp, row.farkas, row.branched, row.open,
              wilson(row.open, trials).high, row.other_velocity, mean(row.milliseconds), mean(row.small_milliseconds),
              row.milliseconds[row.milliseconds.size() / 2], row.milliseconds[row.milliseconds.size() * 99 / 100],
              row.milliseconds.back(), row.disproofs, row.answers, row.roundings);
  std::fflush(stdout);
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  if (argc < 4 || std::atoi(argv[1]) < 1) {
    std::fprintf(stderr, "usage: certify_times TRIALS SEED SET...\n");
    return 2;
  }
  std::puts(
      "set,trials,exact_basis,lp,farkas,branching,open,open_high,other_velocity,mean_ms,small_mean_ms,"
      "median_ms,p99_"
      "ms,max_ms,"
      "disproofs,answers,roundings");
  for (int i = 3; i < argc; ++i) {
    lcpbench::measure(argv[i], std::atoi(argv[1]), std::strtoull(argv[2], nullptr, 10));
  }
  return 0;
}
