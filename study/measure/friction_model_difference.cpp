// How far the post-impact velocities of friction pyramids with 4, 8 and 16 edges lie apart, and beside it what is not
// the model's doing: one CSV row for each pair of answers. Not a test; results/adapters/README.md has its command.
//
//   friction_model_difference TRIALS SEED SET...
//
// Each set (rigid/frictional/...) is solved with 4, 8 and 16 edges on the same bodies, contacts and mu. Answers count
// where both sides are verified (relative velocity residual at most 1e-9; QuickStep's iterates as they are). Frictional
// answers need not be unique: `4 by lemke` is another verified answer to the question with 4 edges.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "core/registry.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"
#include "study/run/open_solver.h"

namespace lcpbench {
namespace {

constexpr double kVerified = 1e-9;

Problem with_edges(const std::string& set, int edges, std::uint64_t seed, std::int64_t trial) {
  Spec spec = parse_spec(set);
  spec.options.emplace_back("edges", std::to_string(edges));
  return open_set(spec.text())->generate(seed, trial);
}

/// v+ of an answer, or empty.
using Solve = std::function<Vector(std::int64_t trial)>;

Solve by(const std::string& solver, const std::string& set, int edges, std::uint64_t seed, bool verified) {
  return [=, opened = std::shared_ptr<TimedSolver>(open_solver(parse_spec(solver)))](std::int64_t trial) -> Vector {
    const Problem problem = with_edges(set, edges, seed, trial);
    TimedAnswer result;
    opened->run(problem, {}, result);
    if (result.answer.z.size() != problem.size()) return {};
    if (verified) {
      const double residual = Evaluator(problem).errors(result.answer).velocity_residual_relative;
      if (!(residual <= kVerified)) return {};
    }
    return post_impact_velocity(*problem.contact(), result.answer.z);
  };
}

double quantile(const std::vector<double>& sorted, double share) {
  return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
}

void compare(const std::string& set, const char* name, const Solve& first, const Solve& second, std::int64_t trials) {
  std::vector<double> differences;
  for (std::int64_t trial = 0; trial < trials; ++trial) {
    const Vector a = first(trial);
    const Vector b = second(trial);
    if (a.size() > 0 && a.size() == b.size()) differences.push_back((a - b).lpNorm<Eigen::Infinity>());
  }
  if (differences.empty()) return;
  std::sort(differences.begin(), differences.end());
  std::printf("\"%s\",%s,%lld,%zu,%.2g,%.2g,%.2g\n", set.c_str(), name, static_cast<long long>(trials),
              differences.size(), quantile(differences, 0.5), quantile(differences, 0.9), differences.back());
  std::fflush(stdout);
}

void measure(const std::string& set, std::int64_t trials, std::uint64_t seed) {
  const Solve four = by("contact_lemke", set, 4, seed, true);
  const Solve eight = by("contact_lemke", set, 8, seed, true);
  const Solve sixteen = by("contact_lemke", set, 16, seed, true);
  compare(set, "model: 4 and 8 edges", four, eight, trials);
  compare(set, "model: 4 and 16 edges", four, sixteen, trials);
  compare(set, "model: 8 and 16 edges", eight, sixteen, trials);
  compare(set, "another answer: 4 by lemke", four, by("lemke", set, 4, seed, true), trials);
  for (const char* iterations : {"20", "1000"}) {
    const std::string quickstep = std::string("ode_quickstep{iterations=") + iterations + "}";
    const std::string name = "solver: 4 by " + quickstep;
    compare(set, name.c_str(), four, by(quickstep, set, 4, seed, false), trials);
  }
  compare(set, "other limits: 4 by ode_step", four, by("ode_step", set, 4, seed, false), trials);
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "friction_model_difference TRIALS SEED SET...\n");
    return 2;
  }
  std::printf("set,answers,trials,compared,median,p90,max\n");
  for (int i = 3; i < argc; ++i) {
    lcpbench::measure(argv[i], std::atoll(argv[1]), std::strtoull(argv[2], nullptr, 10));
  }
}
