// What each method of `auto` takes for each problem to each residual, as a table. auto_fit.py fits the rows of
// native/auto/prediction_rows.inc to it. Not a test; results/auto/README.md has the commands.
//
//   auto_table measure SET...   measures every second trial of the sets, from 0 on; the others are left for checks
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/problem_io.h"
#include "core/islands.h"
#include "core/timed_solve.h"
#include "generators/scenes/scenes.h"
#include "generators/sets.h"
#include "native/auto/features.h"
#include "native/auto/methods.h"
#include "native/contacts/problem_cutter.h"

namespace lcpbench {
namespace {

constexpr double kTimeLimit = 1;
constexpr double kShort = 0.003;  ///< what takes less is measured kRuns times, and the least counts
constexpr int kRuns = 5;
constexpr std::int64_t kTrials = 40;  ///< of sets that have no end

/// Of the residuals that methods are measured to.
constexpr std::array<double, 4> kDigits{2, 4, 6, 9};
/// kDefaultDigits of native/auto/island_race.cpp: it stands for no stated error.
constexpr double kNoErrorDigits = kDigits.back();

double largest_approach(const ContactProblem& contact) {
  double largest = 0;
  for (Index c = 0; c < contact.nc(); ++c) {
    largest = std::max(largest, -(dot_column(contact.N, c, contact.v) + contact.offset(c)));
  }
  return largest;
}

/// The island of the most contacts, as a problem.
Problem largest_island(const Problem& problem) {
  const std::vector<Island> islands = find_islands(*problem.contact());
  const auto largest = std::max_element(islands.begin(), islands.end(), [](const Island& a, const Island& b) {
    return a.contacts.size() < b.contacts.size();
  });
  if (largest == islands.end()) return problem;
  ProblemCutter cutter;
  cutter.load(problem);
  const auto island = std::make_shared<ContactProblem>();
  cutter.cut(largest->contacts, largest->coordinates, problem.contact()->v, true, *island);
  return Problem("", island);
}

void measure(const std::string& set, std::int64_t trial, const Problem& whole) {
  if (whole.contact() == nullptr || whole.contact()->nc() == 0) return;
  const Problem problem = largest_island(whole);
  const ContactProblem* contact = problem.contact();
  if (!(largest_approach(*contact) > 0)) return;  // at rest
  Features features;
  features.begin(*contact, 0);
  Methods methods(std::make_shared<LaterEngines>());
  for (std::size_t k = 0; k < static_cast<std::size_t>(AutoMethod::kOverRelaxedPsor); ++k) {  // as psor
    const auto method = static_cast<AutoMethod>(k);
    const bool for_friction = method == AutoMethod::kFrictionIpm || method == AutoMethod::kContactIpm;
    if (!Methods::takes(method, problem) || (for_friction && !contact->frictional())) continue;
    double load_s = kTimeLimit;
    for (int run = 0; run < (load_s < kShort ? kRuns : 2); ++run) {
      methods.begin(problem, contact->v, false);
      const double begin = thread_cpu_clock_s();
      methods.loaded(method);
      load_s = std::min(load_s, thread_cpu_clock_s() - begin);
    }
    ResumableSolver& solver = methods.loaded(method);
    Answer answer;
    answer.reserve(problem);
    std::printf("%s,%ld,%zu,%d,%.3g", set.c_str(), static_cast<long>(trial), k, contact->frictional() ? 1 : 0,
                1e9 * load_s);
    const auto& values = features.measure(*contact, contact->v, 0);
    for (std::size_t f = 1; f + 1 < kFeatures; ++f) std::printf(",%.4g", values[f]);
    double seconds = 0;
    for (const double digits : kDigits) {
      if (Methods::is_dense(method) && digits != kNoErrorDigits) continue;
      // What fewer digits did not reach in time is not tried again.
      for (int run = 0; run < kRuns && (run == 0 ? seconds < kTimeLimit : seconds < kShort); ++run) {
        answer.clear();
        solver.begin(nullptr, digits == kNoErrorDigits ? 0 : std::pow(10, -digits));
        const double begin = thread_cpu_clock_s();
        solver.go_on(1e300, wall_clock_s() + kTimeLimit, answer);
        const double run_s = thread_cpu_clock_s() - begin;
        seconds = run == 0 ? run_s : std::min(seconds, run_s);
      }
      std::printf(",%.3g,%.3g,%d", solver.work(), 1e9 * seconds, answer.claim == Claim::kSolved ? 1 : 0);
    }
    std::puts("");
  }
  std::fflush(stdout);
}

void measure_all(const std::vector<std::string>& patterns) {
  std::puts("set,trial,method,frictional,load_ns,contacts,coordinates,edges,separator,redundancy,slip,friction,masses,"
            "then work,solve_ns,reached to 2, 4, 6 and 9 digits; of dense methods once");
  for (const std::string& pattern : patterns) {
    if (pattern.ends_with(".json")) {
      measure(pattern, 0, read_problem(pattern));
      continue;
    }
    for (const std::string& name : expand_sets(pattern)) {
      if (name.starts_with(kHeldOutScenes)) continue;
      const auto set = open_set(name);
      const std::int64_t count = set->count().value_or(kTrials);
      for (std::int64_t trial = 0; trial < count; trial += 2) {
        measure(name.substr(0, name.find('{')), trial, set->generate(1, trial));
      }
    }
  }
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  if (argc < 3 || std::string_view(argv[1]) != "measure") {
    std::fputs("usage: auto_table measure SET...\n", stderr);
    return 2;
  }
  lcpbench::measure_all({argv + 2, argv + argc});
}
