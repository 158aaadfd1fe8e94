// How the evaluation in sums of two doubles compares with that in 113 bits throughout, and with the time of `auto`: a
// CSV row for each set. Not a test; results/verification/README.md has its commands.
//
//   verification TRIALS SEED SET[*]...
//
// The answers: of several solvers; and for each problem zeros, and the answer of `auto` once in double its size, and
// with random changes of every entry by 1e-8 of it and by what brings rho or eta close to the bound of the verdict on
// either side. Times are thread CPU, the least of three rounds of auto and of both evaluations in turn, each by the
// rule of timed_solve(): what is short is repeated for 2 ms, and the mean counts. Verification is an Evaluator, its
// truth and the judgement of auto's answer; auto its set-up and solution.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/timed_solve.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"
#include "study/run/open_solver.h"
#include "study/statistics/statistics.h"

namespace lcpbench {
namespace {

constexpr double kSolverLimit_s = 1;
constexpr int kRounds = 3;
constexpr double kBatch_s = 2e-3;
constexpr double kMostRepeats = 1000;
constexpr double kLongSolution_s = 0.05;  ///< beyond it one round is enough

struct Row {
  int problems = 0;
  int answers = 0;
  int decisions = 0;                  ///< other verdicts: solved, criterion or truth
  int worst_rows = 0;                 ///< other rows named as the worst
  double rho = 0;                     ///< largest relative difference of the verdict's measure
  double measures = 0;                ///< and of any measure
  std::vector<double> before, after;  ///< verification over auto
  double longest_s = 0;               ///< verification below 1,000 rows
};

/// What may be off by the rounding of the data, 2^-53, without a difference.
bool is_relative_to_data(const Metric& metric) {
  return metric.value == &Errors::velocity_mismatch || metric.value == &Errors::returned_velocity_error;
}

double relative_difference(double a, double b) {
  if (a == b || (std::isnan(a) && std::isnan(b))) return 0;
  const double difference = std::abs(a - b) / std::abs(b);
  return std::isnan(difference) ? INFINITY : difference;
}

double verdict_measure(const Errors& errors, bool contact) {
  return contact ? errors.velocity_residual_relative : errors.backward_row_norm;
}

template <class Work>
double time_of(int repeats, const Work& work) {
  const double begin = thread_cpu_clock_s();
  for (int k = 0; k < repeats; ++k) work();
  return (thread_cpu_clock_s() - begin) / repeats;
}

/// Of one call; the mean of a batch where that is short.
template <class Work>
double time_of(const Work& work) {
  const double once = time_of(1, work);
  return once >= kBatch_s ? once : time_of(static_cast<int>(std::min(kMostRepeats, 1 + kBatch_s / once)), work);
}

Vector changed(const Vector& z, double size, std::uint64_t key) {
  std::mt19937_64 random(key);
  Vector result = z;
  for (double& value : result) value *= 1 + size * (static_cast<double>(random() >> 11) * 0x1p-52 - 1);
  return result;
}

/// Changes of auto's answer, the last ones at the bound of the verdict.
std::vector<Vector> forged(const Problem& problem, Evaluator& evaluator, const Answer& answer, std::uint64_t key) {
  const bool contact = problem.contact() != nullptr;
  std::vector<Vector> forgeries{Vector::Zero(problem.size())};
  if (answer.z.size() != problem.size() || !answer.z.allFinite()) return forgeries;
  forgeries.push_back(2 * answer.z);
  forgeries.push_back(changed(answer.z, 1e-8, key));
  const double bound = contact ? kSolvedVelocityResidual : kSolvedBackwardError;
  double size = 0x1p-20;
  for (int step = 0; step < 4; ++step) {
    Answer forgery;
    forgery.z = changed(answer.z, size, key);
    const double measure = verdict_measure(evaluator.errors(forgery), contact);
    if (!(measure > 0) || !std::isfinite(measure)) return forgeries;
    size *= bound / measure;
  }
  for (const double side : {1 - 1e-3, 1 - 1e-7, 1.0, 1 + 1e-7, 1 + 1e-3}) {
    forgeries.push_back(changed(answer.z, side * size, key));
  }
  return forgeries;
}

void compare(const Errors& found, const Errors& reference, bool contact, Row& row) {
  ++row.answers;
  row.decisions +=
      found.solved != reference.solved || found.criterion != reference.criterion || found.usable != reference.usable;
  row.worst_rows += found.worst.row != reference.worst.row;
  row.rho =
      std::max(row.rho, relative_difference(verdict_measure(found, contact), verdict_measure(reference, contact)));
  for (const Metric& metric : kMetrics) {
    const double a = found.*metric.value, b = reference.*metric.value;
    if (is_relative_to_data(metric) && std::abs(a - b) <= 0x1p-53) continue;
    row.measures = std::max(row.measures, relative_difference(a, b));
  }
}

double verification_s(const Problem& problem, const Answer& answer, Precision precision) {
  return time_of([&] {
    Evaluator evaluator(problem, precision);
    evaluator.truth();
    evaluator.judge(answer);
  });
}

/// The ratios of auto's answer, whose solution has been timed once.
void measure_times(const Problem& problem, TimedSolver& automatic, const TimedAnswer& first, Row& row) {
  double solution_s = first.times.setup_cpu_s + first.times.solve_cpu_s;
  double before = INFINITY, after = INFINITY;
  for (int round = 0; round < (solution_s < kLongSolution_s ? kRounds : 1); ++round) {
    if (round > 0) {
      TimedAnswer again;
      automatic.run(problem, {.time_limit_s = kSolverLimit_s, .repeat_until_s = kBatch_s}, again);
      solution_s = std::min(solution_s, again.times.setup_cpu_s + again.times.solve_cpu_s);
    }
    before = std::min(before, verification_s(problem, first.answer, Precision::kQuad));
    after = std::min(after, verification_s(problem, first.answer, Precision::kAsNeeded));
  }
  row.before.push_back(before / solution_s);
  row.after.push_back(after / solution_s);
  if (problem.size() < 1000) row.longest_s = std::max(row.longest_s, after);
}

void measure_problem(const Problem& problem, const std::vector<std::unique_ptr<TimedSolver>>& solvers,
                     std::uint64_t key, Row& row) {
  const bool contact = problem.contact() != nullptr;
  Evaluator evaluator(problem), in_quad(problem, Precision::kQuad);
  ++row.problems;
  row.decisions += evaluator.truth() != in_quad.truth();
  Answer automatic;
  for (const auto& solver : solvers) {
    TimedAnswer result;
    const bool is_auto = solver == solvers.front();
    solver->run(problem, {.time_limit_s = kSolverLimit_s, .repeat_until_s = is_auto ? kBatch_s : 0}, result);
    if (is_auto) {
      automatic = result.answer;
      measure_times(problem, *solver, result, row);
    }
    compare(evaluator.errors(result.answer), in_quad.errors(result.answer), contact, row);
  }
  for (Vector& z : forged(problem, in_quad, automatic, key)) {
    Answer forgery = automatic;
    forgery.z = std::move(z);
    compare(evaluator.errors(forgery), in_quad.errors(forgery), contact, row);
  }
}

void measure_set(const std::string& name, std::int64_t trials, std::uint64_t seed,
                 const std::vector<std::unique_ptr<TimedSolver>>& solvers) {
  const auto set = open_set(name);
  Row row;
  for (std::int64_t trial = 0; trial < std::min(trials, set->count().value_or(trials)); ++trial) {
    measure_problem(set->generate(seed, trial), solvers, static_cast<std::uint64_t>(trial), row);
  }
  const Spread before = spread(row.before);
  const Spread after = spread(row.after);
  std::printf("\"%s\",%d,%d,%d,%d,%.1e,%.1e,%.3g,%.3g,%.3g,%.3g,%.3g\n", name.c_str(), row.problems, row.answers,
              row.decisions, row.worst_rows, row.rho, row.measures, before.median, before.max, after.median, after.max,
              1e3 * row.longest_s);
  std::fflush(stdout);
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "verification TRIALS SEED SET...\n");
    return 2;
  }
  std::puts(
      "set,problems,answers,other_decisions,other_worst_rows,largest_difference_of_rho,of_any_measure,"
      "ratio_113_bits_median,ratio_113_bits_max,ratio_median,ratio_max,longest_below_1000_rows_ms");
  try {
    std::vector<std::unique_ptr<lcpbench::TimedSolver>> solvers;
    for (const char* name : {"auto", "psor", "quickstep_sor", "active_set", "friction_ipm"}) {
      solvers.push_back(lcpbench::open_solver(lcpbench::parse_spec(name)));
    }
    for (int i = 3; i < argc; ++i) {
      for (const std::string& set : lcpbench::expand_sets(argv[i])) {
        lcpbench::measure_set(set, std::atoll(argv[1]), std::strtoull(argv[2], nullptr, 10), solvers);
      }
    }
  } catch (const lcpbench::InputError& error) {
    std::fprintf(stderr, "verification: %s\n", error.what());
    return 2;
  }
}
