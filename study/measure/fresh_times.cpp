// What contacts cost that nothing is known of yet: a new object, load, solve. CSV, thread CPU time. Not a test;
// results/native/README.md has its command.
//
//   fresh_times ROUNDS SOLVER... -- SET...   every problem of each set
//
// interface: solver, the class behind the command line; embedding, ContactSolver of native/lcpbench.h.
// make, load and solve are of a new object; total is their sum round by round. again is load and solve by an object
// that has solved the problem before. These columns are medians of ROUNDS rounds, in each of which all solvers take
// turns. least is the least total, wall the least by the wall clock: other threads of a solver are in no other column.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "generators/sets.h"
#include "native/lcpbench.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {
namespace {

/// A Solver and its answer.
class Plain {
 public:
  static constexpr const char* kName = "solver";
  explicit Plain(const std::string& spec) : solver_(make_solver(parse_spec(spec))) {}
  void load(const Problem& problem) { solver_->load(problem); }
  void solve() { solver_->solve({}, answer_); }
  const Answer& answer() const { return answer_; }

 private:
  std::unique_ptr<Solver> solver_;
  Answer answer_;
};

class Embedded {
 public:
  static constexpr const char* kName = "embedding";
  explicit Embedded(const std::string& spec) : solver_(spec) {}
  void load(const Problem& problem) { solver_.load(*problem.contact()); }
  void solve() { solver_.solve(); }
  const Answer& answer() const { return solver_.answer(); }

 private:
  ContactSolver solver_;
};

struct Times {
  std::vector<double> make, load, solve, total, again, wall;
};

struct Candidate {
  std::string spec;
  Times times;
  Answer answer;
};

double us_since(double begin) { return 1e6 * (thread_cpu_clock_s() - begin); }

template <class Interface>
void time_once(const Problem& problem, Candidate& candidate) {
  Times& times = candidate.times;
  const double wall_begin = wall_clock_s();
  double begin = thread_cpu_clock_s();
  Interface solver(candidate.spec);
  times.make.push_back(us_since(begin));
  begin = thread_cpu_clock_s();
  solver.load(problem);
  times.load.push_back(us_since(begin));
  begin = thread_cpu_clock_s();
  solver.solve();
  times.solve.push_back(us_since(begin));
  times.wall.push_back(1e6 * (wall_clock_s() - wall_begin));
  times.total.push_back(times.make.back() + times.load.back() + times.solve.back());
  begin = thread_cpu_clock_s();
  solver.load(problem);
  solver.solve();
  times.again.push_back(us_since(begin));
  candidate.answer = solver.answer();
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double least(const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); }

template <class Interface>
void measure(int rounds, const std::string& set, std::int64_t trial, const Problem& problem,
             const std::vector<std::string>& specs) {
  std::vector<Candidate> candidates;
  for (const std::string& spec : specs) candidates.push_back({.spec = spec, .times = {}, .answer = {}});
  for (int round = 0; round < rounds; ++round) {
    for (Candidate& candidate : candidates) time_once<Interface>(problem, candidate);
  }
  for (Candidate& candidate : candidates) {
    Times& times = candidate.times;
    std::printf("%s,%ld,%ld,%ld,%ld,\"%s\",%s,%d,%s,%d,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f\n", set.c_str(),
                static_cast<long>(trial), static_cast<long>(problem.contact()->nc()),
                static_cast<long>(problem.contact()->ngc()), static_cast<long>(problem.size()), candidate.spec.c_str(),
                Interface::kName, rounds, to_string(candidate.answer.claim),
                Evaluator(problem).errors(candidate.answer).solved ? 1 : 0, median(times.make), median(times.load),
                median(times.solve), median(times.total), median(times.again), least(times.total), least(times.wall));
  }
  std::fflush(stdout);
}

void measure_sets(int rounds, const std::vector<std::string>& specs, const std::vector<std::string>& patterns) {
  std::puts(
      "set,trial,contacts,coordinates,unknowns,solver,interface,rounds,claim,verified,make_us,load_us,solve_us,total_"
      "us,"
      "again_us,least_us,wall_us");
  for (const std::string& pattern : patterns) {
    for (const std::string& name : expand_sets(pattern)) {
      const auto set = open_set(name);
      for (std::int64_t trial = 0; trial < set->count().value_or(20); ++trial) {
        const Problem problem = set->generate(1, trial);
        if (problem.contact() == nullptr) continue;
        measure<Plain>(rounds, name, trial, problem, specs);
        measure<Embedded>(rounds, name, trial, problem, specs);
      }
    }
  }
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  using namespace lcpbench;
  const auto is_separator = [](const char* argument) { return std::string_view(argument) == "--"; };
  char** const separator = std::find_if(argv + std::min(argc, 2), argv + argc, is_separator);
  const std::vector<std::string> specs(argv + std::min(argc, 2), separator);
  if (specs.empty() || argv + argc - separator < 2) {
    std::fputs("usage: fresh_times ROUNDS SOLVER... -- SET...\n", stderr);
    return 2;
  }
  measure_sets(std::max(1, std::atoi(argv[1])), specs, {separator + 1, argv + argc});
}
