// Time of `auto` over that of the fastest of the methods that it chooses among, problem by problem, as CSV. Not a test;
// docs/reference/solvers/auto.md names its command.
//
//   auto_regret PARITY SOLVER... -- SET...   every second problem of each set, from PARITY (0 or 1) on; 2: all
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {
namespace {

constexpr int kRounds = 7;
constexpr double kTimeLimit = 2;
constexpr double kEnoughPerRound = 0.02;      ///< seconds: slower solvers run once
constexpr std::int64_t kTrialsOfRandom = 20;  ///< of sets that have no end

struct Candidate {
  std::string name;
  std::unique_ptr<Solver> solver;
  Answer answer;
  double seconds = std::numeric_limits<double>::infinity();  ///< load and solve, thread CPU, least of all rounds
  double load_s = std::numeric_limits<double>::infinity();
};

void time_once(const Problem& problem, Candidate& candidate) {
  const double begin = thread_cpu_clock_s();
  candidate.solver->load(problem);
  candidate.load_s = std::min(candidate.load_s, thread_cpu_clock_s() - begin);
  candidate.solver->solve({.time_limit_s = kTimeLimit}, candidate.answer);
  candidate.seconds = std::min(candidate.seconds, thread_cpu_clock_s() - begin);
}

void measure(const std::string& set, std::int64_t trial, const Problem& problem, std::vector<Candidate>& candidates) {
  for (Candidate& candidate : candidates)
    candidate.seconds = candidate.load_s = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kRounds; ++round) {
    for (Candidate& candidate : candidates) {
      if (round == 0 || candidate.seconds < kEnoughPerRound) time_once(problem, candidate);
    }
  }
  const ContactProblem* contact = problem.contact();
  const long contacts = contact == nullptr ? 0 : static_cast<long>(contact->nc());
  const long coordinates = contact == nullptr ? 0 : static_cast<long>(contact->ngc());
  for (const Candidate& candidate : candidates) {
    const std::string quoted = '"' + candidate.name + '"';
    const bool solved = Evaluator(problem).errors(candidate.answer).solved;
    std::printf("%s,%ld,%ld,%ld,%ld,%s,%.1f,%.1f,%s,%d,%ld,\"%s\"\n", set.c_str(), static_cast<long>(trial), contacts,
                coordinates, static_cast<long>(problem.size()), quoted.c_str(), 1e6 * candidate.seconds,
                1e6 * candidate.load_s, to_string(candidate.answer.claim), solved ? 1 : 0,
                static_cast<long>(candidate.answer.counters.pivots), candidate.answer.detail.c_str());
  }
  std::fflush(stdout);
}

void measure_all(std::int64_t parity, std::vector<Candidate>& candidates, const std::vector<std::string>& patterns) {
  std::puts("set,trial,contacts,coordinates,unknowns,solver,us,load_us,claim,verified,pivots,detail");
  for (const std::string& pattern : patterns) {
    for (const std::string& name : expand_sets(pattern)) {
      const auto set = open_set(name);
      const std::int64_t count = set->count().value_or(kTrialsOfRandom);
      for (std::int64_t trial = parity == 2 ? 0 : parity; trial < count; trial += parity == 2 ? 1 : 2) {
        measure(name, trial, set->generate(1, trial), candidates);
      }
    }
  }
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  using namespace lcpbench;
  std::vector<Candidate> candidates;
  int next = 2;
  for (; next < argc && std::string_view(argv[next]) != "--"; ++next) {
    candidates.push_back({.name = argv[next], .solver = make_solver(parse_spec(argv[next])), .answer = {}});
  }
  const std::vector<std::string> sets(argv + std::min(next + 1, argc), argv + argc);
  if (candidates.empty() || sets.empty()) {
    std::fputs("usage: auto_regret 0|1|2 SOLVER... -- SET...\n", stderr);
    return 2;
  }
  measure_all(std::atoi(argv[1]), candidates, sets);
}
