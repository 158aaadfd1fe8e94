// What models of friction cost and how far they are from the round cone, on captured steps, as CSV. Not a test;
// results/models/README.md has its commands.
//
//   friction_models ladder SET...   every rung of every step: error, the solver's, difference from the cone, time
//   friction_models mixture SET...  every step at 1e-3 m/s: the cheapest sufficient rung, the mixture by islands, cost
//
//   friction_models cone SET...     cone_ipm and siconos_fc3d on every step: residual of the cone, time

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "generators/sets.h"
#include "study/evaluation/evaluation.h"
#include "study/evaluation/fastest_contact.h"
#include "study/evaluation/friction_model.h"
#include "study/models/ladder.h"
#include "study/models/pyramid.h"
#include "study/run/open_solver.h"

namespace lcpbench {
namespace {

constexpr double kError = 1e-3;  // m/s
constexpr double kTimeLimitS = 10;

/// A rung on all islands of a step.
struct Row {
  double error = 0, solver_error = 0, difference = 0, time_s = 0;
  std::vector<RungAnswer> islands;
};

Row climb_all(const std::vector<LadderIsland>& islands, Rung rung) {
  Row row;
  for (const LadderIsland& island : islands) {
    row.islands.push_back(island.ladder->climb(rung, rung == Rung::kConeRough ? kError : kFinestTurn));
    const RungAnswer& answer = row.islands.back();
    row.error = larger_or_nan(row.error, answer.error_m_per_s);
    row.solver_error = larger_or_nan(row.solver_error, answer.solver_error_m_per_s);
    row.time_s += answer.time_s;
  }
  return row;
}

double difference(const std::vector<LadderIsland>& islands, const Row& row, const Row& cone) {
  double largest = 0;
  for (std::size_t i = 0; i < islands.size(); ++i) {
    if (!row.islands[i].answered() || cone.islands[i].claim != Claim::kSolved) return RungAnswer::kNone;
    largest = std::max(
        largest,
        fastest_contact(islands[i].ladder->contacts(), row.islands[i].velocity - cone.islands[i].velocity).m_per_s);
  }
  return largest;
}

void print_step(const std::string& set, std::int64_t trial, const ContactProblem& contact) {
  std::printf("%s,%lld,%lld", set.c_str(), static_cast<long long>(trial), static_cast<long long>(contact.nc()));
}

void print_ladder(const std::string& set, std::int64_t trial, const Problem& problem,
                  const std::vector<LadderIsland>& islands) {
  const Row cone = climb_all(islands, Rung::kCone);
  print_step(set, trial, *problem.contact());
  std::printf(",%zu", islands.size());
  for (const Rung rung : kRungs) {
    const Row row = rung == Rung::kCone ? cone : climb_all(islands, rung);
    std::printf(",%.2g,%.2g,%.2g,%.3g", row.error, row.solver_error, difference(islands, row, cone), row.time_s);
  }
  std::printf("\n");
}

/// Each island by the cheapest of all models that meets the error, as if that were known; and as `solve` climbs.
void print_mixture(const std::string& set, std::int64_t trial, const Problem& problem,
                   const std::vector<LadderIsland>& islands) {
  double four_s = 0;
  double cheapest_s = 0;
  double chosen_s = 0;
  double spent_s = 0;
  double cone_s = 0;
  double sixteen_s = 0;
  double error = 0;
  bool met = true;
  std::string rungs;
  for (const LadderIsland& island : islands) {
    double cheapest = std::numeric_limits<double>::infinity();
    for (const Rung rung : {Rung::kNormals, Rung::kEdges4, Rung::kConeRough, Rung::kCone}) {
      const RungAnswer answer = island.ladder->climb(rung, kError);
      if (rung == Rung::kEdges4) four_s += answer.time_s;
      if (rung == Rung::kCone) cone_s += answer.time_s;
      if (answer.meets(kError)) cheapest = std::min(cheapest, answer.time_s);
    }
    sixteen_s += island.ladder->climb(Rung::kEdges16, kError).time_s;
    const Climb climbed = climb(*island.ladder, kError, false);
    cheapest_s += cheapest;
    chosen_s += climbed.chosen.time_s;
    spent_s += climbed.spent_s;
    error = larger_or_nan(error, climbed.chosen.error_m_per_s);
    met = met && climbed.met;
    const char* const name = to_string(climbed.chosen.rung);
    if (rungs.find(name) == std::string::npos) rungs += (rungs.empty() ? "" : " ") + std::string(name);
  }
  print_step(set, trial, *problem.contact());
  std::printf(",%zu,%s,%d,%.3g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g\n", islands.size(), rungs.c_str(), met ? 1 : 0, error,
              four_s, cheapest_s, chosen_s, spent_s, sixteen_s, cone_s);
}

void print_cone(const std::string& set, std::int64_t trial, const Problem& problem) {
  static const std::vector<std::string> kSolvers{"cone_ipm{cone=true}", "siconos_fc3d{cone=true}"};
  static std::vector<std::unique_ptr<TimedSolver>> solvers;
  if (solvers.empty()) {
    for (const std::string& solver : kSolvers) solvers.push_back(open_solver(parse_spec(solver)));
  }
  print_step(set, trial, *problem.contact());
  std::vector<Vector> velocities;
  for (const auto& solver : solvers) {
    TimedAnswer timed;
    const TimedRequest request{.time_limit_s = kTimeLimitS, .repeat_until_s = 2e-4};
    solver->run(problem, request, timed);
    Errors errors;
    velocities.emplace_back();
    if (timed.answer.z.size() == problem.size()) {
      errors = Evaluator(problem).errors(timed.answer);
      measure_cone(problem, timed.answer, errors);
      velocities.back() = post_impact_velocity(*problem.contact(), timed.answer.z);
    }
    std::printf(",%s,%.3g,%.4g", to_string(timed.answer.claim), errors.velocity_residual_relative,
                timed.times.setup_cpu_s + timed.times.solve_cpu_s);
  }
  const bool both = velocities[0].size() > 0 && velocities[1].size() > 0;
  std::printf(",%.3g\n", both ? fastest_contact(*problem.contact(), velocities[0] - velocities[1]).m_per_s : NAN);
}

void measure(const std::string& what, const std::string& name) {
  const auto set = open_set(name);
  for (std::int64_t trial = 0; trial < *set->count(); ++trial) {
    const Problem problem = set->generate(1, trial);
    if (what == "cone") {
      print_cone(name, trial, problem);
    } else {
      const std::vector<LadderIsland> islands = ladder_islands(problem, name, kTimeLimitS);
      what == "ladder" ? print_ladder(name, trial, problem, islands) : print_mixture(name, trial, problem, islands);
    }
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  if (argc < 3 || (what != "ladder" && what != "mixture" && what != "cone")) {
    std::fprintf(stderr, "friction_models ladder|mixture|cone SET...\n");
    return 2;
  }
  std::printf("set,trial,contacts,%s", what == "cone" ? "" : "islands,");
  if (what == "ladder") {
    const char* separator = "";
    for (const lcpbench::Rung rung : lcpbench::kRungs) {
      const char* const name = to_string(rung);
      std::printf("%s%s_error,%s_solver_error,%s_difference,%s_s", separator, name, name, name, name);
      separator = ",";
    }
  } else if (what == "mixture") {
    std::printf("rungs,met,error,four_s,cheapest_s,chosen_s,spent_s,sixteen_s,cone_s");
  } else {
    std::printf("cone_ipm,cone_ipm_rho,cone_ipm_s,fc3d,fc3d_rho,fc3d_s,difference");
  }
  std::printf("\n");
  for (int i = 2; i < argc; ++i) {
    for (const std::string& name : lcpbench::expand_sets(argv[i])) lcpbench::measure(what, name);
  }
}
