#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "generators/sets.h"
#include "study/run/open_solver.h"
#include "tests/support/solving.h"

namespace lcpbench::quickstep_sor_test {
namespace {

using testing::solve;

constexpr std::uint64_t kSeed = 20120101;

// ODE takes normal x (normal x tangent) for minus the tangent. On the sets' grid of 2^-40 that holds to 2e-12, in these
// scenes to rounding.
Problem with_orthonormal_frames(const Problem& problem) {
  RigidScene scene = *problem.scene();
  for (RigidContact& contact : scene.contacts) {
    contact.normal.normalize();
    contact.tangent -= contact.normal.dot(contact.tangent) * contact.normal;
    contact.tangent.normalize();
  }
  return Problem(problem.name(), scene);
}

struct Sweeps {
  int iterations = 20;
  double w = 1.3;
  double cfm = 0;
  std::uint32_t seed = 0;

  std::string spec(const std::string& solver) const {
    char text[128];
    std::snprintf(text, sizeof text, "%s{iterations=%d,w=%.17g,cfm=%.17g,seed=%u}", solver.c_str(), iterations, w, cfm,
                  seed);
    return text;
  }
};

// Of the iterates of QuickStep and of quickstep_sor, relative to the largest entry of z.
double difference_to_ode(const Problem& problem, const Vector& ode, const Vector& other) {
  if (ode.size() != problem.size() || other.size() != problem.size()) return std::numeric_limits<double>::infinity();
  const double scale = ode.lpNorm<Eigen::Infinity>();
  const double difference = (ode - other).lpNorm<Eigen::Infinity>();
  if (difference == 0) return 0;
  return difference / scale < INFINITY ? difference / scale : std::numeric_limits<double>::infinity();
}

double largest_difference(const Sweeps& sweeps, const std::vector<Problem>& problems) {
  const auto quickstep = open_solver(parse_spec(sweeps.spec("ode_quickstep")));
  double largest = 0;
  for (const Problem& problem : problems) {
    TimedAnswer ode;
    quickstep->run(problem, {}, ode);
    const Vector own = solve(sweeps.spec("quickstep_sor"), problem).z;
    largest = std::max(largest, difference_to_ode(problem, ode.answer.z, own));
  }
  return largest;
}

class AgreementTest : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const std::string& why = find_solver("ode_quickstep").unavailable;
    if (!why.empty()) GTEST_SKIP() << "ode_quickstep is not built: " << why;
  }
};

// One island and several, shuffles at 8, 16, ...: every iterate is that of the library itself. Each sweep adds
// roundings, which differ between the two, and which some settings let grow.
TEST_P(AgreementTest, EveryIterateIsQuickSteps) {
  std::vector<Problem> problems;
  for (std::int64_t trial = 0; trial < 12; ++trial) {
    problems.push_back(with_orthonormal_frames(open_set(GetParam())->generate(kSeed, trial)));
  }
  for (int iterations = 1; iterations <= 40; ++iterations) {
    EXPECT_LE(largest_difference({.iterations = iterations}, problems), 1e-12) << iterations;
  }
  for (const Sweeps& sweeps :
       {Sweeps{.iterations = 0}, Sweeps{.iterations = 30, .w = 0.75}, Sweeps{.iterations = 30, .w = 1, .cfm = 0.01},
        Sweeps{.iterations = 30, .seed = 4294967295}, Sweeps{.iterations = 200, .w = 1}}) {
    EXPECT_LE(largest_difference(sweeps, problems), 1e-9) << sweeps.spec("quickstep_sor");
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, AgreementTest,
                         ::testing::Values("rigid/exp1", "rigid/exp2{redundancy=combination}", "rigid/exp5-1e5",
                                           "rigid/exp1{bodies_max=12,nc_max=60}", "rigid/frictional/exp1",
                                           "rigid/frictional/exp2{redundancy=combination}",
                                           "rigid/frictional/exp1{normals=axis}",
                                           "rigid/frictional/exp1{bodies_max=12,nc_max=60}"),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return std::isalnum(c) == 0; }, '_');
                           return name;
                         });

TEST(QuickstepSorTest, ClaimsOnlyWhatTheEvaluationConfirms) {
  int claimed = 0;
  for (const char* name : {"rigid/exp1", "rigid/frictional/exp1", "rigid/frictional/exp1{edges=8}",
                           "paper/monotone/exp1", "paper/monotone/exp3", "paper/copositive/exp1"}) {
    const auto set = open_set(name);
    for (std::int64_t trial = 0; trial < 20; ++trial) {
      const Problem problem = set->generate(kSeed, trial);
      const Answer answer = solve("quickstep_sor{iterations=3000,w=1}", problem);
      EXPECT_TRUE(answer.claim == Claim::kSolved || answer.claim == Claim::kIterationLimit) << answer.detail;
      const bool presses = (answer.z.head(problem.contact()->nc()).array() > 0).any();  // else nothing approaches
      EXPECT_EQ(answer.counters.iterations, presses ? 3000 : 0);
      if (answer.claim != Claim::kSolved) continue;
      ++claimed;
      EXPECT_LE(Evaluator(problem).errors(answer).velocity_residual_relative, 2e-8) << problem.name();
    }
  }
  EXPECT_GT(claimed, 20);
}

TEST(QuickstepSorTest, TheSeedMattersFromTheFirstShuffleOn) {
  const Problem problem = open_set("rigid/frictional/exp1")->generate(kSeed, 1);
  const auto iterate = [&](int iterations, int seed) {
    return solve("quickstep_sor{iterations=" + std::to_string(iterations) + ",seed=" + std::to_string(seed) + "}",
                 problem)
        .z;
  };
  EXPECT_EQ(iterate(8, 0), iterate(8, 1));
  EXPECT_NE(iterate(9, 0), iterate(9, 1));
}

}  // namespace
}  // namespace lcpbench::quickstep_sor_test
