// What frictionless walls cost velocity_ipm and others: one CSV row for each size. Not a test; results/native/README.md
// has its commands.
//
//   velocity_ipm_walls SOLVER ROWSxCOLUMNS...     SOLVER: a spec; or sparse, dense: velocity_ipm with its sparse
//   algebra and finish, and with dense algebra and no finish (the method alone)
//
// The last line is the slope of log(set-up + solve) over log(contacts), by least squares, and the times that this gives
// for 2,400 and 10,000 contacts.

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "core/timed_solve.h"
#include "study/evaluation/evaluation.h"
#include "study/open_solver.h"
#include "tests/brick_wall.h"

namespace lcpbench {
namespace {

struct Timing {
  double contacts = 0;
  double seconds = 0;
};

Spec solver_named(const std::string& name) {
  if (name == "sparse") return parse_spec("velocity_ipm{algebra=sparse}");
  if (name == "dense") return parse_spec("velocity_ipm{algebra=dense,finish=false}");
  return parse_spec(name);
}

Timing measure(const std::string& name, int rows, int columns) {
  const Problem problem("wall", testing::brick_wall(rows, columns));
  TimedAnswer timed;
  open_solver(solver_named(name))->run(problem, {.time_limit_s = 600, .repeat_until_s = 0.25}, timed);
  const Answer& answer = timed.answer;
  const Errors errors = Evaluator(problem).errors(answer);
  std::printf("%d,%d,%td,%td,\"%s\",%.4g,%.4g,%lld,%lld,%s,%s,%.2g\n", rows, columns, problem.size(),
              problem.contact()->ngc(), name.c_str(), timed.times.setup_cpu_s, timed.times.solve_cpu_s,
              static_cast<long long>(answer.counters.iterations),
              static_cast<long long>(answer.counters.factorizations), to_string(answer.claim),
              errors.solved ? "solved" : "not solved", errors.velocity_residual_relative);
  std::fflush(stdout);
  return {static_cast<double>(problem.size()), timed.times.setup_cpu_s + timed.times.solve_cpu_s};
}

void print_fit(const std::vector<Timing>& timings) {
  double mean_x = 0, mean_y = 0, xx = 0, xy = 0;
  for (const Timing& t : timings) {
    mean_x += std::log(t.contacts) / static_cast<double>(timings.size());
    mean_y += std::log(t.seconds) / static_cast<double>(timings.size());
  }
  for (const Timing& t : timings) {
    const double x = std::log(t.contacts) - mean_x;
    xx += x * x;
    xy += x * (std::log(t.seconds) - mean_y);
  }
  const double slope = xy / xx;
  const auto fitted = [&](double contacts) { return std::exp(mean_y + slope * (std::log(contacts) - mean_x)); };
  std::printf("# slope %.3f; fitted: 2400 contacts %.4g s, 10000 contacts %.4g s\n", slope, fitted(2400),
              fitted(10000));
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "velocity_ipm_walls sparse|dense|SPEC ROWSxCOLUMNS ROWSxCOLUMNS...\n");
    return 2;
  }
  std::printf("rows,columns,contacts,ngc,solver,setup_s,solve_s,iterations,factorizations,claim,verdict,rho\n");
  std::vector<lcpbench::Timing> timings;
  for (int i = 2; i < argc; ++i) {
    int rows = 0;
    int columns = 0;
    if (std::sscanf(argv[i], "%dx%d", &rows, &columns) != 2) return 2;
    timings.push_back(lcpbench::measure(argv[1], rows, columns));
  }
  lcpbench::print_fit(timings);
}
