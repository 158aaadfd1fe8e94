// Regret of auto{error=T} for each target T, problem by problem, as CSV, and its statistics on stderr: the time over
// that of the fastest answer whose residual is at most T. Not a test; results/regret/README.md has its command.
//
//   auto_regret PARITY SOLVER... -- SET...   every second problem of each set, from PARITY (0 or 1) on; 2: all
//   auto_regret all PARITY SOLVER... -- SET...   the CSV is time and residual of every solver
//   auto_regret write SCENE FILE   one of the scenes below as a problem file, for `lcpbench solve`
//
// Beside the sets of `lcpbench sets`: pile:COLUMNS:LAYERS:MU[:SEED[:SPREAD]], wall:ROWS:COLUMNS:MU and
// stack:HEIGHT[:MU], one problem each. After them @SEED:DECADES:SPEED varies the masses and the velocities of the
// bodies.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/io/problem_io.h"
#include "core/registry.h"
#include "core/timed_solve.h"
#include "generators/random.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"
#include "study/measure/box_stacks.h"
#include "study/measure/brick_wall.h"
#include "study/measure/sphere_piles.h"

namespace lcpbench {
namespace {

constexpr int kRounds = 3;
constexpr int kRunsInARow = 4;  ///< in each round, so that no solver gains by what runs before it
constexpr double kTimeLimit = 10;
constexpr double kTimeLimitOfScenes = 30;     ///< of the scenes that are made here
constexpr double kEnoughPerRound = 0.02;      ///< seconds: slower solvers run once
constexpr std::int64_t kTrialsOfRandom = 20;  ///< of sets that have no end

constexpr double kLargeRegret = 3;

struct Target {
  double residual = 0;
  std::string solver;  ///< auto{error=residual}
  std::vector<std::pair<double, std::string>> regrets;
  int missed = 0;  ///< problems on which another solver reached the target, and auto did not
};

struct Candidate {
  std::string name;
  std::unique_ptr<Solver> solver;
  Answer answer;
  double seconds = std::numeric_limits<double>::infinity();  ///< load and solve, thread CPU, least of all rounds
  double load_s = std::numeric_limits<double>::infinity();
  double residual = std::numeric_limits<double>::infinity();  ///< of an answer claimed as solved
  bool is_verified = false;
};

void time_once(const Problem& problem, double limit_s, Candidate& candidate) {
  const double begin = thread_cpu_clock_s();
  candidate.solver->load(problem);
  candidate.load_s = std::min(candidate.load_s, thread_cpu_clock_s() - begin);
  candidate.solver->solve({.time_limit_s = limit_s}, candidate.answer);
  candidate.seconds = std::min(candidate.seconds, thread_cpu_clock_s() - begin);
}

/// "set,trial,contacts,coordinates,unknowns"
std::string columns_of(const std::string& set, std::int64_t trial, const Problem& problem) {
  const ContactProblem* contact = problem.contact();
  const Index contacts = contact == nullptr ? 0 : contact->nc();
  const Index coordinates = contact == nullptr ? 0 : contact->ngc();
  return set + "," + std::to_string(trial) + "," + std::to_string(contacts) + "," + std::to_string(coordinates) + "," +
         std::to_string(problem.size());
}

/// Of one problem, on which all candidates have been run. @param columns those of the problem; "": no CSV
void add_regret(const std::string& place, const std::string& columns, const std::vector<Candidate>& candidates,
                Target& target) {
  const Candidate* best = nullptr;
  const Candidate* own = nullptr;
  for (const Candidate& candidate : candidates) {
    if (!(candidate.residual <= target.residual)) continue;
    if (candidate.name == target.solver) own = &candidate;
    if (best == nullptr || candidate.seconds < best->seconds) best = &candidate;
  }
  if (best == nullptr) return;
  if (!columns.empty()) {
    std::printf("%s,%g,", columns.c_str(), target.residual);
    if (own != nullptr) std::printf("%.1f,%.2g", 1e6 * own->seconds, own->residual);
    std::printf("%s,\"%s\",\"%s\",%.1f\n", own != nullptr ? "" : ",", own != nullptr ? own->answer.detail.c_str() : "",
                best->name.c_str(), 1e6 * best->seconds);
  }
  if (own == nullptr) {
    ++target.missed;
    std::fprintf(stderr, "%s missed %s; %s reached it\n", target.solver.c_str(), place.c_str(), best->name.c_str());
    return;
  }
  target.regrets.emplace_back(own->seconds / best->seconds, place + ", " + best->name);
}

/// Geometric mean with its 95 % interval (normal, of the logarithms), 99 % quantile, share above kLargeRegret with its
/// interval [Wilson 1927], and the worst problems with the fastest solver.
void report(Target& target) {
  auto& regrets = target.regrets;
  if (regrets.empty()) return;
  std::sort(regrets.begin(), regrets.end());
  const auto count = static_cast<double>(regrets.size());
  double sum = 0, squares = 0, large = 0;
  for (const auto& [regret, place] : regrets) {
    sum += std::log(regret);
    squares += std::log(regret) * std::log(regret);
    large += regret > kLargeRegret ? 1 : 0;
  }
  constexpr double kZ = 1.96;
  const double mean = sum / count;
  const double error = kZ * std::sqrt(std::max(squares / count - mean * mean, 0.0) / count);
  const double share = large / count;
  const double middle = (share + kZ * kZ / (2 * count)) / (1 + kZ * kZ / count);
  const double half =
      kZ / (1 + kZ * kZ / count) * std::sqrt(share * (1 - share) / count + kZ * kZ / (4 * count * count));
  const auto at = static_cast<std::size_t>(std::ceil(0.99 * count)) - 1;
  std::fprintf(stderr, "%s: %.0f problems, geometric mean %.3f [%.3f, %.3f], 99 %% quantile %.2f, ",
               target.solver.c_str(), count, std::exp(mean), std::exp(mean - error), std::exp(mean + error),
               regrets[at].first);
  std::fprintf(stderr, "above %.0f: %.4f [%.4f, %.4f], missed %d\n", kLargeRegret, share, std::max(middle - half, 0.0),
               middle + half, target.missed);
  for (std::size_t k = 0; k < std::min<std::size_t>(5, regrets.size()); ++k) {
    const auto& [regret, place] = regrets[regrets.size() - 1 - k];
    std::fprintf(stderr, "  %.2f %s\n", regret, place.c_str());
  }
}

void measure(const Problem& problem, double limit_s, std::vector<Candidate>& candidates) {
  for (Candidate& candidate : candidates)
    candidate.seconds = candidate.load_s = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kRounds; ++round) {
    for (Candidate& candidate : candidates) {
      for (int run = 0; run < kRunsInARow; ++run) {
        const bool is_first = round == 0 && run == 0;
        if (is_first || candidate.seconds < kEnoughPerRound) time_once(problem, limit_s, candidate);
      }
    }
  }
  Evaluator evaluator(problem);
  for (Candidate& candidate : candidates) {
    const Errors errors = evaluator.errors(candidate.answer);
    const bool has_answer = candidate.answer.claim == Claim::kSolved;
    candidate.is_verified = errors.solved;
    candidate.residual = has_answer ? errors.velocity_residual_relative : std::numeric_limits<double>::infinity();
  }
}

void write_all(const std::string& columns, const std::vector<Candidate>& candidates) {
  for (const Candidate& candidate : candidates) {
    std::printf("%s,\"%s\",%.1f,%.1f,%s,%d,%.2g,%ld,\"%s\"\n", columns.c_str(), candidate.name.c_str(),
                1e6 * candidate.seconds, 1e6 * candidate.load_s, to_string(candidate.answer.claim),
                candidate.is_verified ? 1 : 0, candidate.residual, static_cast<long>(candidate.answer.counters.pivots),
                candidate.answer.detail.c_str());
  }
}

/// Bodies of other masses, by factors up to 10^decades both ways, and of other velocities, each by up to `speed`.
void vary(std::uint64_t seed, double decades, double speed, RigidScene& scene) {
  DrawSequence draws({.stream = stream_id("varied scenes"), .seed = seed}, Purpose::kBodyMass);
  const auto number = [&draws] { return static_cast<double>(draws.signed_grid()) * kGridStep; };
  for (RigidBody& body : scene.bodies) {
    const double factor = std::pow(10, decades * number());
    body.mass *= factor;
    body.inertia *= factor;
    for (double& each : body.linear_velocity) each += speed * number();
    for (double& each : body.angular_velocity) each += speed * number();
  }
}

/// The scene that a name such as pile:6:8:0.5 describes. @returns false for other names
bool make_scene(const std::string& name, RigidScene& scene) {
  int first = 0, second = 0;
  double mu = 0;
  double spread = 0, decades = 0, speed = 0;
  long seed = 7;
  if (const std::size_t at = name.find('@'); at != std::string::npos) {
    if (std::sscanf(name.c_str() + at, "@%ld:%lf:%lf", &seed, &decades, &speed) != 3) return false;
    if (!make_scene(name.substr(0, at), scene)) return false;
    vary(static_cast<std::uint64_t>(seed), decades, speed, scene);
    return true;
  }
  if (std::sscanf(name.c_str(), "pile:%d:%d:%lf:%ld:%lf", &first, &second, &mu, &seed, &spread) >= 3) {
    scene = testing::sphere_pile(
        {.columns = first, .layers = second, .mu = mu, .seed = static_cast<std::uint64_t>(seed), .spread = spread});
  } else if (std::sscanf(name.c_str(), "wall:%d:%d:%lf", &first, &second, &mu) == 3) {
    scene = mu > 0 ? testing::frictional_brick_wall(first, second, mu) : testing::brick_wall(first, second);
  } else if (std::sscanf(name.c_str(), "stack:%d:%lf", &first, &mu) >= 1) {
    scene = testing::box_stacks({.stacks = 1, .height = first, .edges = 4, .mu = mu > 0 ? mu : 0.5});
  } else {
    return false;
  }
  return true;
}

void measure_all(std::int64_t parity, bool writes_all, std::vector<Candidate>& candidates, std::vector<Target>& targets,
                 const std::vector<std::string>& patterns) {
  const auto measure_one = [&](const std::string& name, std::int64_t trial, const Problem& problem, double limit_s) {
    measure(problem, limit_s, candidates);
    const std::string columns = columns_of(name, trial, problem);
    if (writes_all) write_all(columns, candidates);
    for (Target& target : targets) {
      add_regret(name + " " + std::to_string(trial), writes_all ? "" : columns, candidates, target);
    }
    std::fflush(stdout);
  };
  std::printf("set,trial,contacts,coordinates,unknowns,%s\n",
              writes_all ? "solver,us,load_us,claim,verified,residual,pivots,detail"
                         : "target,us,residual,detail,fastest,fastest_us");
  for (const std::string& pattern : patterns) {
    if (RigidScene scene; make_scene(pattern, scene)) {
      measure_one(pattern, 0, Problem(pattern, std::move(scene)), kTimeLimitOfScenes);
      continue;
    }
    for (const std::string& name : expand_sets(pattern)) {
      const auto set = open_set(name);
      const std::int64_t count = set->count().value_or(kTrialsOfRandom);
      for (std::int64_t trial = parity == 2 ? 0 : parity; trial < count; trial += parity == 2 ? 1 : 2) {
        measure_one(name, trial, set->generate(1, trial), kTimeLimit);
      }
    }
  }
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  using namespace lcpbench;
  std::vector<Candidate> candidates;
  if (argc == 4 && std::string_view(argv[1]) == "write") {
    RigidScene scene;
    if (!make_scene(argv[2], scene)) {
      std::fprintf(stderr, "%s is none of the scenes that are made here\n", argv[2]);
      return 2;
    }
    write_problem(Problem(argv[2], std::move(scene)), argv[3]);
    return 0;
  }
  const bool writes_all = argc > 1 && std::string_view(argv[1]) == "all";
  const int first = writes_all ? 2 : 1;
  int next = first + 1;
  for (; next < argc && std::string_view(argv[next]) != "--"; ++next) {
    candidates.push_back({.name = argv[next], .solver = make_solver(parse_spec(argv[next])), .answer = {}});
  }
  const std::vector<std::string> sets(argv + std::min(next + 1, argc), argv + argc);
  if (candidates.empty() || sets.empty()) {
    std::fputs("usage: auto_regret [all] 0|1|2 SOLVER... -- SET...\n       auto_regret write SCENE FILE\n", stderr);
    return 2;
  }
  std::vector<Target> targets;
  for (const Candidate& candidate : candidates) {
    double residual = 0;
    if (std::sscanf(candidate.name.c_str(), "auto{error=%lf}", &residual) != 1) continue;
    targets.push_back({.residual = residual, .solver = candidate.name, .regrets = {}});
  }
  measure_all(std::atoi(argv[first]), writes_all, candidates, targets, sets);
  for (Target& target : targets) report(target);
}
