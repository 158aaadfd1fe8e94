// How Lemke's two engines compare on the paper's problems: do they take the same pivots, and how much faster is the
// kernel engine at the same instruction-set level (LCPBENCH_ISA)?
//
//   lemke_engines_benchmark SET PROBLEMS [SEED]
//
// Times are thread CPU time of set-up and solve together, the engines in alternating order on each problem.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <limits>
#include <string>
#include <vector>

#include "core/isa.h"
#include "core/timed_solve.h"
#include "generators/sets.h"
#include "native/lemke/lemke.h"

namespace {

using namespace lcpbench;

struct Engine {
  explicit Engine(LemkeEngine engine) : solver(LemkeSettings{.engine = engine}) {}
  Lemke solver;
  std::vector<LemkePivot> pivots;
  Answer answer;

  /// One timed run without recording, then one that records the pivots.
  double run(const Problem& problem) {
    solver.record_pivots(nullptr);
    const double begin = thread_cpu_clock_s();
    solver.load(problem);
    solver.solve({}, answer);
    const double seconds = thread_cpu_clock_s() - begin;
    pivots.clear();
    solver.record_pivots(&pivots);
    solver.solve({}, answer);
    return seconds;
  }
};

struct Totals {
  double seconds_dense = 0;
  double seconds_kernel = 0;
  double log_ratios = 0;
  long same = 0;
  long claimed_dense = 0;
  long claimed_kernel = 0;
  long pivots = 0;

  void add(const Engine& dense, const Engine& kernel, double dense_s, double kernel_s) {
    seconds_dense += dense_s;
    seconds_kernel += kernel_s;
    log_ratios += std::log(dense_s / kernel_s);
    same += dense.pivots == kernel.pivots && dense.answer.claim == kernel.answer.claim ? 1 : 0;
    claimed_dense += dense.answer.claim == Claim::kSolved ? 1 : 0;
    claimed_kernel += kernel.answer.claim == Claim::kSolved ? 1 : 0;
    pivots += static_cast<long>(dense.pivots.size());
  }
};

void compare(const std::string& name, std::int64_t problems, std::uint64_t seed) {
  const auto set = open_set(name);
  Engine dense(LemkeEngine::kDense);
  Engine kernel(LemkeEngine::kKernel);
  Totals totals;
  for (std::int64_t trial = 0; trial < problems; ++trial) {
    const Problem problem = set->generate(seed, trial);
    double kernel_s = trial % 2 == 0 ? kernel.run(problem) : 0;
    const double dense_s = dense.run(problem);
    if (trial % 2 != 0) kernel_s = kernel.run(problem);
    totals.add(dense, kernel, dense_s, kernel_s);
  }
  const auto count = static_cast<double>(problems);
  std::printf(
      "%s, %s: same pivots and claim %ld of %.0f; claimed solved dense %ld, kernel %ld; %.1f pivots; "
      "dense %.2f us, kernel %.2f us; ratio of means %.1f, geometric mean %.1f\n",
      set->name().c_str(), to_string(isa_level()), totals.same, count, totals.claimed_dense, totals.claimed_kernel,
      static_cast<double>(totals.pivots) / count, 1e6 * totals.seconds_dense / count,
      1e6 * totals.seconds_kernel / count, totals.seconds_dense / totals.seconds_kernel,
      std::exp(totals.log_ratios / count));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3 || argc > 4) {
    std::fprintf(stderr, "usage: lemke_engines_benchmark SET PROBLEMS [SEED]\n");
    return 2;
  }
  try {
    compare(argv[1], std::max(1L, std::atol(argv[2])), argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
