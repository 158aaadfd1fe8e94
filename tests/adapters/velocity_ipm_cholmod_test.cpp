// CHOLMOD behind the native interior point, in its worker, as a study runs it.
#include <gtest/gtest.h>

#include "generators/sets.h"
#include "study/evaluation/evaluation.h"
#include "study/run/open_solver.h"
#include "tests/support/brick_wall.h"
#include "tests/support/textbook_lcps.h"
#include "tests/support/two_chains.h"

namespace lcpbench::velocity_ipm_cholmod_test {
namespace {

constexpr int kMostSteps = 25;
constexpr TimedRequest kPatient{.time_limit_s = 600};

class VelocityIpmCholmodTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string why = why_unavailable(find_solver("velocity_ipm_cholmod"));
    if (!why.empty()) GTEST_SKIP() << why;
  }
};

Answer solve(const std::string& solver, const Problem& problem, const TimedRequest& request = kPatient) {
  TimedAnswer result;
  open_solver(parse_spec(solver))->run(problem, request, result);
  return result.answer;
}

/// |u - u'| in the scale of the velocity that the two solved for.
double velocity_difference(const Problem& problem, const Answer& a, const Answer& b) {
  const ContactProblem& contact = *problem.contact();
  const Vector difference = post_impact_velocity(contact, a.z) - post_impact_velocity(contact, b.z);
  return difference.lpNorm<Eigen::Infinity>() / contact.v.lpNorm<Eigen::Infinity>();
}

TEST_F(VelocityIpmCholmodTest, GivesTheVelocityOfVelocityIpmOnAWallWhateverItsSettings) {
  const Problem wall("wall", testing::brick_wall(10, 12));
  const Answer native = solve("velocity_ipm", wall);
  ASSERT_EQ(native.claim, Claim::kSolved) << native.detail;
  for (const std::string factor : {"auto", "simplicial", "supernodal"}) {
    for (const std::string ordering : {"given", "amd", "metis"}) {
      const std::string solver = "velocity_ipm_cholmod{factor=" + factor + ",ordering=" + ordering + "}";
      const Answer answer = solve(solver, wall);
      ASSERT_EQ(answer.claim, Claim::kSolved) << solver << ": " << answer.detail;
      EXPECT_LE(answer.counters.iterations, kMostSteps) << solver;
      EXPECT_LE(velocity_difference(wall, answer, native), 1e-11) << solver;
      EXPECT_LE(Evaluator(wall).errors(answer).velocity_residual_relative, 1e-12) << solver;
    }
  }
}

// Dense inertia is one block; redundant contacts and conditioning of 1e5 as in the paper. The answers of both are good
// to the rounding of the problem times its condition.
TEST_F(VelocityIpmCholmodTest, GivesTheVelocityOfVelocityIpmOnMonotoneProblems) {
  for (const std::string name :
       {"paper/monotone/exp1", "paper/monotone/exp2{redundancy=combination}", "paper/monotone/exp5-1e5"}) {
    const auto set = open_set(name);
    const auto cholmod = open_solver(parse_spec("velocity_ipm_cholmod"));
    for (int trial = 0; trial < 40; ++trial) {
      const Problem problem = set->generate(33, trial);
      TimedAnswer result;
      cholmod->run(problem, kPatient, result);
      ASSERT_EQ(result.answer.claim, Claim::kSolved) << name << ", trial " << trial << ": " << result.answer.detail;
      ASSERT_TRUE(Evaluator(problem).errors(result.answer).solved) << name << ", trial " << trial;
      const Answer dense = solve("velocity_ipm", problem);
      EXPECT_LE(velocity_difference(problem, result.answer, dense), 1e-7) << name << ", trial " << trial;
    }
  }
}

TEST_F(VelocityIpmCholmodTest, RefusesWhatItCannotTakeAndRegularisesNothing) {
  ContactProblem contact;
  contact.v = testing::vector_of({-1, -2});
  contact.N = Matrix(Matrix::Identity(2, 2));
  contact.D = Matrix(2, 0);
  contact.edges = {0, 0};
  contact.mu = Vector::Zero(2);
  contact.inertia = InverseInertia{Matrix::Identity(2, 2)};
  const Answer inverse_only = solve("velocity_ipm_cholmod", Problem("inverse only", contact));
  EXPECT_EQ(inverse_only.claim, Claim::kUnsupported);
  EXPECT_EQ(inverse_only.z.size(), 0);
  contact.inertia = FactoredInertia{Matrix(testing::ones(2)), testing::ones(1)};
  const Answer singular = solve("velocity_ipm_cholmod", Problem("singular", contact));
  EXPECT_EQ(singular.claim, Claim::kUnsupported);
  EXPECT_NE(singular.detail.find("positive definite"), std::string::npos) << singular.detail;
  EXPECT_EQ(solve("velocity_ipm_cholmod", Problem("bare", Lcp{Matrix::Identity(2, 2), -testing::ones(2)})).claim,
            Claim::kUnsupported);
  contact.inertia = DenseInertia{2 * Matrix::Identity(2, 2)};
  const Answer regular = solve("velocity_ipm_cholmod", Problem("regular", contact));
  ASSERT_EQ(regular.claim, Claim::kSolved);
  EXPECT_LE((regular.z - testing::vector_of({2, 4})).lpNorm<Eigen::Infinity>(), 1e-14);
}

}  // namespace
}  // namespace lcpbench::velocity_ipm_cholmod_test
