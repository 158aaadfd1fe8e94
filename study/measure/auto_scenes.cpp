// What islands, leaving out and warm starts save, as CSV. Not a test; results/native/README.md has its command.
//
//   auto_scenes islands REPEATS   stacks of two cubes, 2 to 200 of them, every third flying: parts against the whole
//   auto_scenes resting STEPS     stacks that stay at rest: pivots from z = 0 and from the last answer
//   auto_scenes flying REPEATS    stacks of which a part flies apart, and seesaws: leaving out against all contacts
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "study/evaluation/evaluation.h"
#include "study/measure/box_stacks.h"
#include "study/measure/seesaws.h"

namespace lcpbench {

SolverDefinition lcpbench_solver_auto();

namespace {

using testing::box_stacks;
using testing::BoxStacks;
using testing::falling_velocity;

const Options kWhole{{"islands", "false"}, {"leave_out", "false"}};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

struct Timed {
  Answer answer;
  double seconds = 0;  ///< load and solve, thread CPU, median
  bool verified = false;
};

Timed run(const Problem& problem, const Options& options, int repeats) {
  const auto solver = lcpbench_solver_auto().make(options);
  Timed timed;
  std::vector<double> seconds;
  for (int k = 0; k < repeats; ++k) {
    const double begin = thread_cpu_clock_s();
    solver->load(problem);
    solver->solve({.time_limit_s = 60}, timed.answer);
    seconds.push_back(thread_cpu_clock_s() - begin);
  }
  timed.seconds = median(seconds);
  timed.verified = timed.answer.claim == Claim::kSolved && Evaluator(problem).errors(timed.answer).solved;
  return timed;
}

void compare_islands(int repeats) {
  std::puts("edges,islands,contacts,parts_s,whole_s,ratio,parts_verified,whole_verified,velocity_difference");
  for (const int edges : {0, 4}) {
    for (const int stacks : {2, 5, 10, 20, 50, 100, 200}) {
      const Problem problem("stacks", box_stacks({.stacks = stacks, .height = 2, .edges = edges, .lifted = 3}));
      const Timed parts = run(problem, {}, repeats);
      const ContactProblem& contact = *problem.contact();
      std::printf("%d,%d,%ld,%.4g,", edges, stacks, static_cast<long>(contact.nc()), parts.seconds);
      const Timed whole = run(problem, kWhole, stacks > 20 && edges > 0 ? 1 : repeats);
      double difference = -1;
      if (whole.answer.z.size() == parts.answer.z.size()) {
        difference = (post_impact_velocity(contact, parts.answer.z) - post_impact_velocity(contact, whole.answer.z))
                         .lpNorm<Eigen::Infinity>();
      }
      std::printf("%.4g,%.3g,%d,%d,%.2g\n", whole.seconds, whole.seconds / parts.seconds, parts.verified ? 1 : 0,
                  whole.verified ? 1 : 0, difference);
      std::fflush(stdout);
    }
  }
}

/// A stack of which the cubes from `first` on fly up, each faster than the one below it.
RigidScene flying_stack(int height, int first, int edges) {
  RigidScene scene = box_stacks({.stacks = 1, .height = height, .edges = edges});
  for (int b = first; b < height; ++b) {
    scene.bodies[static_cast<std::size_t>(b)].linear_velocity.z() = 0.25 * (b - first + 1);
  }
  return scene;
}

struct LoadAndSolve {
  double load_s = 0, solve_s = 0;  ///< thread CPU, medians
  Answer answer;
  bool verified = false;
};

LoadAndSolve run_apart(const Problem& problem, const Options& options, int repeats) {
  const auto solver = lcpbench_solver_auto().make(options);
  LoadAndSolve timed;
  std::vector<double> load_s, solve_s;
  for (int k = 0; k < repeats; ++k) {
    const double begin = thread_cpu_clock_s();
    solver->load(problem);
    const double loaded = thread_cpu_clock_s();
    solver->solve({.time_limit_s = 60}, timed.answer);
    load_s.push_back(loaded - begin);
    solve_s.push_back(thread_cpu_clock_s() - loaded);
  }
  timed.load_s = median(load_s);
  timed.solve_s = median(solve_s);
  timed.verified = timed.answer.claim == Claim::kSolved && Evaluator(problem).errors(timed.answer).solved;
  return timed;
}

void print_leaving_out(const char* scene, const Problem& problem, int edges, int repeats) {
  const LoadAndSolve some = run_apart(problem, {}, repeats);
  const LoadAndSolve all = run_apart(problem, {{"leave_out", "false"}}, repeats);
  const double ratio = (all.load_s + all.solve_s) / (some.load_s + some.solve_s);
  std::printf("%s,%d,%ld,%.4g,%.4g,%.4g,%.4g,%.3g,%d,%d,\"%s\"\n", scene, edges,
              static_cast<long>(problem.contact()->nc()), some.load_s, some.solve_s, all.load_s, all.solve_s, ratio,
              some.verified ? 1 : 0, all.verified ? 1 : 0, some.answer.detail.c_str());
  std::fflush(stdout);
}

void compare_leaving_out(int repeats) {
  std::puts("scene,edges,contacts,load_s,solve_s,all_load_s,all_solve_s,ratio,verified,all_verified,detail");
  for (const int edges : {0, 4}) {
    for (const int height : {16, 24, 40, 80, 200, 750}) {
      if (edges > 0 && (height == 80 || height == 750)) continue;  // dense and slow; sparse from 200 on
      for (const int first : {height / 4, height / 2, 3 * height / 4}) {
        const std::string name = "stack, " + std::to_string(height - first) + " of " + std::to_string(height) + " fly";
        const int runs = height > 100 || (edges > 0 && height > 24) ? std::min(repeats, 3) : repeats;
        print_leaving_out(('"' + name + '"').c_str(), Problem("stack", flying_stack(height, first, edges)), edges,
                          runs);
      }
    }
    for (const int planks : {17, 24, 45, 170}) {
      if (edges > 0 && planks == 45) continue;
      const int runs = planks > 100 ? std::min(repeats, 3) : repeats;
      print_leaving_out("seesaws", Problem("seesaws", testing::seesaws(planks, edges)), edges, runs);
    }
    for (const auto& [falling, flying] : {std::pair(1, 24), std::pair(1, 78), std::pair(1, 168), std::pair(85, 84)}) {
      if (edges > 0) continue;
      const Problem problem("catapult", testing::catapult(falling, flying));
      print_leaving_out("catapult", problem, edges, falling + flying > 100 ? std::min(repeats, 3) : repeats);
    }
  }
}

struct Sums {
  long pivots = 0;
  double seconds = 0;  ///< in solve(), thread CPU
};

void solve_step(Solver& solver, const SolveRequest& request, Answer& answer, Sums& sums) {
  const double begin = thread_cpu_clock_s();
  solver.solve(request, answer);
  sums.seconds += thread_cpu_clock_s() - begin;
  sums.pivots += answer.counters.pivots;
}

void count_pivots(const BoxStacks& shape, int steps) {
  const Problem first("resting", box_stacks(shape));
  const auto cold = lcpbench_solver_auto().make({});
  const auto warm = lcpbench_solver_auto().make({});
  cold->load(first);
  warm->load(first);
  Answer last, anew;
  warm->solve({}, last);
  Sums of_cold, of_warm;
  int verified = 0;
  for (int step = 1; step <= steps; ++step) {
    ContactProblem contact = *first.contact();
    contact.v = falling_velocity(shape, step);
    cold->update(contact.v);
    warm->update(contact.v);
    const Vector start = last.z;
    solve_step(*cold, {}, anew, of_cold);
    solve_step(*warm, {.start = &start}, last, of_warm);
    Evaluator evaluator(Problem("step", contact));
    const bool claimed = last.claim == Claim::kSolved && anew.claim == Claim::kSolved;
    if (claimed && evaluator.errors(last).solved && evaluator.errors(anew).solved) ++verified;
  }
  std::printf("%d,%g,%d,%d,%ld,%d,%ld,%ld,%.3g,%.4g,%.4g,%d\n", shape.edges, shape.fresh, shape.stacks, shape.height,
              static_cast<long>(first.contact()->nc()), steps, of_cold.pivots, of_warm.pivots,
              static_cast<double>(of_cold.pivots) / static_cast<double>(of_warm.pivots), of_cold.seconds,
              of_warm.seconds, verified);
  std::fflush(stdout);
}

void count_all_pivots(int steps) {
  std::puts("edges,fresh,stacks,height,contacts,steps,cold_pivots,warm_pivots,ratio,cold_s,warm_s,verified");
  for (const int edges : {0, 4}) {
    for (const double fresh : {1.0, 0.2}) {
      for (const int height : {1, 2, 4, 8}) {
        count_pivots({.stacks = 4, .height = height, .edges = edges, .fresh = fresh}, steps);
      }
    }
  }
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  const std::string_view mode = argc == 3 ? argv[1] : "";
  const int count = argc == 3 ? std::atoi(argv[2]) : 0;
  if (count > 0 && mode == "islands") {
    lcpbench::compare_islands(count);
  } else if (count > 0 && mode == "resting") {
    lcpbench::count_all_pivots(count);
  } else if (count > 0 && mode == "flying") {
    lcpbench::compare_leaving_out(count);
  } else {
    std::fputs("usage: auto_scenes islands REPEATS | auto_scenes resting STEPS | auto_scenes flying REPEATS\n", stderr);
    return 2;
  }
}
