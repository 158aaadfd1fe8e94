// Where rest is a solution, and whether `auto` finds it, problem by problem, as CSV. Not a test;
// docs/reference/solvers/auto.md names its command.
//
//   rest_steps SOLVER... -- SET...
//
// A row has the fastest velocity at any contact after the impact, over that before it: of the impulses that leave the
// least kinetic energy, which is below 1e-6 exactly where rest is a solution, and of each solver.
#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"
#include "study/evaluation/fastest_contact.h"
#include "study/measure/least_energy_velocity.h"

namespace lcpbench {
namespace {

using testing::least_energy_velocity;

constexpr std::int64_t kTrialsOfRandom = 20;  ///< of sets that have no end
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

struct Candidate {
  std::string name;
  std::unique_ptr<Solver> solver;
  Answer answer;
};

void compare(const std::string& set, std::int64_t trial, const Problem& problem, std::vector<Candidate>& candidates) {
  const ContactProblem& contact = *problem.contact();
  const double scale = fastest_contact(contact, contact.v).m_per_s;
  const Vector rest = least_energy_velocity(contact);
  std::printf("%s,%ld,%ld,%ld,%.3g,%.2g", set.c_str(), static_cast<long>(trial), static_cast<long>(contact.nc()),
              static_cast<long>(contact.ngc()), scale,
              rest.size() > 0 ? fastest_contact(contact, rest).m_per_s / scale : kNone);
  for (Candidate& candidate : candidates) {
    candidate.solver->load(problem);
    candidate.solver->solve({.time_limit_s = 10}, candidate.answer);
    const bool solved = Evaluator(problem).errors(candidate.answer).solved;
    const Vector u = solved ? post_impact_velocity(contact, candidate.answer.z) : Vector();
    std::printf(",%.2g,\"%s\"", solved ? fastest_contact(contact, u).m_per_s / scale : kNone,
                candidate.answer.detail.c_str());
  }
  std::puts("");
  std::fflush(stdout);
}

void compare_all(std::vector<Candidate>& candidates, const std::vector<std::string>& patterns) {
  std::printf("set,trial,contacts,coordinates,before,least_energy");
  for (const Candidate& candidate : candidates) std::printf(",\"%s\",detail", candidate.name.c_str());
  std::puts("");
  for (const std::string& pattern : patterns) {
    for (const std::string& name : expand_sets(pattern)) {
      const auto set = open_set(name);
      const std::int64_t count = set->count().value_or(kTrialsOfRandom);
      for (std::int64_t trial = 0; trial < count; ++trial) {
        const Problem problem = set->generate(1, trial);
        if (problem.contact() != nullptr) compare(name, trial, problem, candidates);
      }
    }
  }
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  using namespace lcpbench;
  std::vector<Candidate> candidates;
  int next = 1;
  for (; next < argc && std::string_view(argv[next]) != "--"; ++next) {
    candidates.push_back({.name = argv[next], .solver = make_solver(parse_spec(argv[next])), .answer = {}});
  }
  const std::vector<std::string> sets(argv + std::min(next + 1, argc), argv + argc);
  if (candidates.empty() || sets.empty()) {
    std::fputs("usage: rest_steps SOLVER... -- SET...\n", stderr);
    return 2;
  }
  compare_all(candidates, sets);
}
