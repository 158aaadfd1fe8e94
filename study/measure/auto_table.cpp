// What each method of `auto` takes for each problem to each residual, as a table, and the rows of
// native/auto/prediction_rows.inc fitted to such a table. Not a test; results/auto/README.md has its commands.
//
//   auto_table measure SET...   the second half of the trials is left out: every second one, from 0 on
//   auto_table fit TABLE        the rows
//   auto_table check TABLE      leaves one family after the other out of the fit: the error of the predictions on it
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/problem_io.h"
#include "core/islands.h"
#include "core/timed_solve.h"
#include "generators/scenes/scenes.h"
#include "generators/sets.h"
#include "native/contacts/islands.h"
#include "native/auto/methods.h"
#include "study/measure/auto_table.h"
#include "study/statistics/statistics.h"

namespace lcpbench {
namespace {

constexpr double kTimeLimit = 1;
constexpr double kShort = 0.003;  ///< what takes less is measured kRuns times, and the least counts
constexpr int kRuns = 5;
constexpr std::int64_t kTrials = 40;  ///< of sets that have no end

using testing::kDigits;
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
  ProblemCutter cutter(problem);
  return Problem("", cutter.cut(largest->contacts, largest->coordinates, problem.contact()->v, true));
}

void measure(const std::string& set, std::int64_t trial, const Problem& whole) {
  if (whole.contact() == nullptr || whole.contact()->nc() == 0) return;
  const Problem problem = largest_island(whole);
  const ContactProblem* contact = problem.contact();
  if (!(largest_approach(*contact) > 0)) return;  // at rest
  Features features;
  features.begin(*contact, 0);
  Methods methods(std::make_shared<LaterEngines>());
  for (std::size_t k = 0; k < kAutoMethods; ++k) {
    const auto method = static_cast<AutoMethod>(k);
    if (!Methods::takes(method, problem) || (method == AutoMethod::kFrictionIpm && !contact->frictional())) continue;
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

template <std::size_t kCount>
double sum_of(const std::array<double, kCount>& row, const std::array<double, kFeatures>& features) {
  double sum = 0;
  for (std::size_t k = 0; k < kCount; ++k) sum += row[k] * features[k];
  return sum;
}

/// scene/stack of scene/stack/ode
std::string family_of(const std::string& set) { return set.substr(0, set.find('/', set.find('/') + 1)); }

void check(const std::vector<testing::MeasuredCost>& costs) {
  std::set<std::string> families;
  for (const auto& cost : costs) families.insert(family_of(cost.set));
  for (const std::string& left_out : families) {
    std::vector<testing::MeasuredCost> others;
    std::copy_if(costs.begin(), costs.end(), std::back_inserter(others),
                 [&](const auto& cost) { return family_of(cost.set) != left_out; });
    // log2 of measured over predicted work
    std::map<std::pair<AutoMethod, bool>, std::vector<double>> errors;
    std::map<std::pair<AutoMethod, bool>, prediction::Row> rows;
    for (const auto& cost : costs) {
      if (family_of(cost.set) != left_out || !cost.reached) continue;
      const std::pair key{cost.method, cost.frictional};
      if (!rows.contains(key)) rows[key] = testing::fit_row(others, key.first, key.second);
      const prediction::Row& row = rows[key];
      errors[key].push_back(std::log2(std::max(row.weight * cost.work, 1.0)) - sum_of(row.solve, cost.features));
    }
    for (const auto& [key, logs] : errors) {
      const Spread of_set = spread(logs);
      std::printf("%s,%zu,%d,%zu,%.2f,%.2f\n", left_out.c_str(), static_cast<std::size_t>(key.first), key.second ? 1 : 0,
                  logs.size(), std::exp2(of_set.mean), std::exp2(of_set.sigma));
    }
  }
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  using namespace lcpbench;
  const std::string_view command = argc > 2 ? argv[1] : "";
  if (command == "measure") {
    measure_all({argv + 2, argv + argc});
  } else if (command == "fit" && argc == 3) {
    std::fputs(testing::rows_text(testing::read_costs(argv[2])).c_str(), stdout);
  } else if (command == "check" && argc == 3) {
    std::puts("family left out,method,frictional,problems,measured over predicted,spread");
    check(testing::read_costs(argv[2]));
  } else {
    std::fputs("usage: auto_table measure SET...\n       auto_table fit|check TABLE\n", stderr);
    return 2;
  }
}
