// What frictionless walls cost velocity_ipm and others: one CSV row for each size. Not a test; results/native/README.md
// has its commands.
//
//   velocity_ipm_walls SOLVER ROWSxCOLUMNS...     SOLVER: a spec; or sparse, dense: velocity_ipm with its sparse
//   algebra and finish, and with dense algebra and no finish (the method alone)
//
// The last line is the slope of log(set-up + solve) over log(contacts), by least squares, and the times that this gives
// for 2,400 and 10,000 contacts.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "core/timed_solve.h"
#include "study/evaluation/evaluation.h"
#include "study/run/open_solver.h"
#include "study/measure/brick_wall.h"

namespace lcpbench {
namespace {

struct Wall {
  int rows = 0;
  int columns = 0;
  double mu = 0;

  RigidScene scene() const {
    return mu > 0 ? testing::frictional_brick_wall(rows, columns, mu) : testing::brick_wall(rows, columns);
  }
};

bool parse_wall(const char* text, Wall& wall) {
  int end = 0;
  if (std::sscanf(text, "%dx%d%n", &wall.rows, &wall.columns, &end) != 2) return false;
  if (text[end] == '\0') return true;
  int tail = 0;
  return std::sscanf(text + end, ":%lf%n", &wall.mu, &tail) == 1 && text[end + tail] == '\0';
}

struct Timing {
  double contacts = 0;
  double seconds = 0;
};

Spec solver_named(const std::string& name) {
  if (name == "sparse") return parse_spec("velocity_ipm{algebra=sparse}");
  if (name == "dense") return parse_spec("velocity_ipm{algebra=dense,finish=false}");
  return parse_spec(name);
}

Timing measure(const std::string& name, const Wall& wall) {
  const Problem problem("wall", wall.scene());
  TimedAnswer timed;
  open_solver(solver_named(name))->run(problem, {.time_limit_s = 600, .repeat_until_s = 0.25}, timed);
  const Answer& answer = timed.answer;
  const Errors errors = Evaluator(problem).errors(answer);
  std::printf("%d,%d,%g,%td,%td,%td,\"%s\",%.4g,%.4g,%lld,%lld,%s,%s,%.2g,%s\n", wall.rows, wall.columns, wall.mu,
              problem.contact()->nc(), problem.contact()->ngc(), problem.size(), name.c_str(), timed.times.setup_cpu_s,
              timed.times.solve_cpu_s,
              static_cast<long long>(std::max(answer.counters.iterations, answer.counters.pivots)),
              static_cast<long long>(answer.counters.factorizations), to_string(answer.claim),
              errors.solved ? "solved" : "not solved", errors.velocity_residual_relative, answer.detail.c_str());
  std::fflush(stdout);
  return {static_cast<double>(problem.contact()->nc()), timed.times.setup_cpu_s + timed.times.solve_cpu_s};
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
  if (argc < 3) {
    std::fprintf(stderr, "brick_wall_times sparse|dense|SPEC ROWSxCOLUMNS[:MU]...\n");
    return 2;
  }
  std::printf("rows,columns,mu,contacts,ngc,n,solver,setup_s,solve_s,steps,factorizations,claim,verdict,rho,detail\n");
  std::vector<lcpbench::Timing> timings;
  for (int i = 2; i < argc; ++i) {
    lcpbench::Wall wall;
    if (!lcpbench::parse_wall(argv[i], wall)) return 2;
    timings.push_back(lcpbench::measure(argv[1], wall));
  }
  if (timings.size() > 1) lcpbench::print_fit(timings);
}
