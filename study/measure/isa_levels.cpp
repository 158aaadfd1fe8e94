// What the instruction-set levels are worth: the same problems by the same solver at each level that this processor
// has, in one process, the levels of each problem in rotating order. Not a test; results/native/README.md has its
// command.
//
//   isa_levels PROBLEMS SEED SET...
//
// Times are means of thread CPU time of set-up and solve together over the problems that every level solves, verified.
// A ratio is that of the summed times of a level to AVX-512's, with its 95 % bootstrap interval over problems.

#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "core/isa.h"
#include "core/timed_solve.h"
#include "generators/sets.h"
#include "native/active_set/active_set.h"
#include "native/contact_lemke/contact_lemke.h"
#include "native/lemke/lemke.h"
#include "study/evaluation/evaluation.h"
#include "study/statistics/statistics.h"

namespace lcpbench {
namespace {

constexpr std::array kLevels{IsaLevel::kBaseline, IsaLevel::kAvx2, IsaLevel::kAvx512};
/// As `lcpbench bench` repeats: caches are warm, as in a loop.
constexpr TimedRequest kRequest{.repeat_until_s = 2e-4};

struct Method {
  const char* name;
  bool friction;
  std::unique_ptr<Solver> (*make)(IsaLevel level);
};

constexpr std::array kMethods{Method{"contact_lemke", true,
                                     [](IsaLevel level) -> std::unique_ptr<Solver> {
                                       return std::make_unique<ContactLemke>(ContactLemkeSettings{}, level);
                                     }},
                              Method{"active_set", false,
                                     [](IsaLevel level) -> std::unique_ptr<Solver> {
                                       return std::make_unique<ActiveSet>(ActiveSetSettings{}, level);
                                     }},
                              Method{"lemke", true, [](IsaLevel level) -> std::unique_ptr<Solver> {
                                       return std::make_unique<Lemke>(LemkeSettings{}, level);
                                     }}};

struct Compared {
  explicit Compared(const Method& the_method) : method(the_method) {
    for (std::size_t level = 0; level < kLevels.size(); ++level) solvers[level] = method.make(kLevels[level]);
  }

  void add(const Problem& problem, Evaluator& evaluator, int trial) {
    std::array<double, kLevels.size()> seconds{};
    for (std::size_t turn = 0; turn < kLevels.size(); ++turn) {
      const std::size_t level = (turn + static_cast<std::size_t>(trial)) % kLevels.size();
      timed_solve(*solvers[level], problem, kRequest, result);
      if (result.answer.claim != Claim::kSolved || !evaluator.errors(result.answer).solved) return;
      seconds[level] = result.times.setup_cpu_s + result.times.solve_cpu_s;
    }
    for (std::size_t level = 0; level < kLevels.size(); ++level) times[level].push_back(seconds[level]);
  }

  double mean_us(std::size_t level) const {
    double sum = 0;
    for (const double seconds : times[level]) sum += seconds;
    return 1e6 * sum / static_cast<double>(times[level].size());
  }

  const Method& method;
  std::array<std::unique_ptr<Solver>, kLevels.size()> solvers;
  std::array<std::vector<double>, kLevels.size()> times;
  TimedAnswer result;
};

void measure(const ProblemSet& set, int problems, std::uint64_t seed) {
  std::vector<std::unique_ptr<Compared>> compared;
  const bool friction = set.generate(seed, 0).contact()->frictional();
  for (const Method& method : kMethods) {
    if (method.friction || !friction) compared.push_back(std::make_unique<Compared>(method));
  }
  for (int trial = 0; trial < problems; ++trial) {
    const Problem problem = set.generate(seed, trial);
    Evaluator evaluator(problem);
    for (const auto& each : compared) each->add(problem, evaluator, trial);
  }
  for (const auto& each : compared) {
    const Estimate baseline = ratio_of_sums(each->times[0], each->times[2]);
    const Estimate avx2 = ratio_of_sums(each->times[1], each->times[2]);
    std::printf("\"%s\",%s,%d,%zu,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f\n", set.name().c_str(),
                each->method.name, problems, each->times[0].size(), each->mean_us(0), each->mean_us(1),
                each->mean_us(2), baseline.value, baseline.low, baseline.high, avx2.value, avx2.low, avx2.high);
  }
  std::fflush(stdout);
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "isa_levels PROBLEMS SEED SET...\n");
    return 2;
  }
  if (lcpbench::best_isa_level() != lcpbench::IsaLevel::kAvx512) {
    std::fprintf(stderr, "isa_levels: this processor has no AVX-512\n");
    return 1;
  }
  std::printf(
      "set,solver,problems,timed,baseline_us,avx2_us,avx512_us,baseline_ratio,baseline_low,baseline_high,avx2_ratio,"
      "avx2_low,avx2_high\n");
  for (int i = 3; i < argc; ++i) {
    const auto set = lcpbench::open_set(argv[i]);
    lcpbench::measure(*set, std::atoi(argv[1]), std::strtoull(argv[2], nullptr, 10));
  }
}
