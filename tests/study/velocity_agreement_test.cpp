// What a user relies on: answers with different impulses and one velocity agree, and a velocity that is another one is
// seen.

#include "study/validate/velocity_agreement.h"

#include <limits>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "generators/sets.h"

namespace lcpbench::velocity_agreement_test {
namespace {

struct Judged {
  Answer answer;
  Errors errors;
};

Judged judge(const Problem& problem, const Answer& answer) { return {answer, Evaluator(problem).errors(answer)}; }

Judged solve(const Problem& problem, const char* solver) {
  const std::unique_ptr<Solver> native = make_solver(parse_spec(solver));
  Answer answer;
  native->load(problem);
  native->solve({}, answer);
  const Judged judged = judge(problem, answer);
  EXPECT_TRUE(judged.errors.solved) << solver << " on " << problem.name();
  return judged;
}

bool agree(const Problem& problem, const Judged& a, const Judged& b) {
  const VelocityAgreement agreement(problem);
  return agreement.agree(agreement.side(a.answer, a.errors), agreement.side(b.answer, b.errors));
}

/// One body of mass 1 that falls on two contacts with the same normal: any split of the impulse will do.
Problem twice_the_same_contact() {
  ContactProblem contact;
  contact.v = Vector::Constant(1, -1.0);
  contact.N = Matrix(Matrix::Ones(1, 2));
  contact.D = Matrix(1, 0);
  contact.edges = {0, 0};
  contact.mu = Vector::Zero(2);
  contact.inertia = DenseInertia{Matrix::Identity(1, 1)};
  return {"twice", contact};
}

Answer answer_of(const Vector& z) {
  Answer answer;
  answer.claim = Claim::kSolved;
  answer.z = z;
  return answer;
}

TEST(VelocityAgreementTest, ImpulsesMayDifferWhereTheVelocityDoesNot) {
  const Problem problem = twice_the_same_contact();
  const Judged left = judge(problem, answer_of(Vector{{1.0, 0.0}}));
  const Judged right = judge(problem, answer_of(Vector{{0.25, 0.75}}));
  ASSERT_TRUE(left.errors.solved && right.errors.solved);
  EXPECT_TRUE(agree(problem, left, right));
}

/// An inertia that 113 bits prove definite, and whose smallest eigenvalue in double is rounding, often below 0.
TEST(VelocityAgreementTest, AnAnswerAgreesWithItselfWhereDoubleSeesNoDefiniteInertia) {
  Matrix inertia = Matrix::Ones(7, 7);
  inertia.diagonal().tail(6).array() += std::numeric_limits<double>::epsilon();
  ContactProblem contact;
  contact.v = -Vector::Unit(7, 0);
  contact.N = Matrix(Matrix::Ones(7, 1));
  contact.D = Matrix(7, 0);
  contact.edges = {0};
  contact.mu = Vector::Zero(1);
  contact.inertia = DenseInertia{inertia};
  const Problem problem("nearly singular", contact);
  ASSERT_EQ(Evaluator(problem).truth(), Truth::kSolvable);
  const Judged answer = judge(problem, answer_of(Vector::Ones(1)));
  ASSERT_TRUE(answer.errors.solved);
  EXPECT_TRUE(agree(problem, answer, answer));
}

/// Three impulses of 3e9 N s that cancel exactly, and in double all but 1e-7 m/s of them.
TEST(VelocityAgreementTest, ImpulsesThatCancelMayRoundMoreThanTheirVelocity) {
  const double part = 0.3F;
  ContactProblem contact;
  contact.v = Vector{{0.0, -1.0}};
  contact.N = Matrix{{part, 1 - part, -1, 0}, {0, 0, 0, 1}};
  contact.D = Matrix(2, 0);
  contact.edges = {0, 0, 0, 0};
  contact.mu = Vector::Zero(4);
  contact.inertia = DenseInertia{Matrix::Identity(2, 2)};
  const Problem problem("squeezed", contact);
  const double squeeze = 1e10 / 3;
  const Judged loose = judge(problem, answer_of(Vector{{0.0, 0.0, 0.0, 1.0}}));
  const Judged tight = judge(problem, answer_of(Vector{{squeeze, squeeze, squeeze, 1.0}}));
  ASSERT_TRUE(loose.errors.solved && tight.errors.solved);
  EXPECT_TRUE(agree(problem, loose, tight));
  Judged wrong = loose;
  wrong.answer.velocity = Vector{{0.0, 1e-3}};
  EXPECT_FALSE(agree(problem, loose, wrong));
}

TEST(VelocityAgreementTest, SolversOfEveryKindAgreeAtEveryConditioning) {
  for (const char* set :
       {"paper/monotone/exp1", "paper/monotone/exp2{redundancy=combination}", "paper/monotone/exp5-1e5",
        "paper/monotone/exp5-1e8", "paper/monotone/exp5-1e10", "rigid/exp2", "planted/definite"}) {
    for (std::int64_t trial = 0; trial < 30; ++trial) {
      const Problem problem = open_set(set)->generate(5, trial);
      ASSERT_TRUE(VelocityAgreement::applies(problem, true));
      EXPECT_TRUE(agree(problem, solve(problem, "lemke"), solve(problem, "contact_lemke"))) << set << ", " << trial;
      EXPECT_TRUE(agree(problem, solve(problem, "lemke"), solve(problem, "active_set"))) << set << ", " << trial;
    }
  }
}

TEST(VelocityAgreementTest, AVelocityThatIsAnotherOneIsSeen) {
  for (const char* set : {"paper/monotone/exp1", "paper/monotone/exp5-1e8", "rigid/exp2"}) {
    const Problem problem = open_set(set)->generate(5, 3);
    const Judged right = solve(problem, "contact_lemke");
    Judged wrong = right;
    wrong.answer.velocity = post_impact_velocity(*problem.contact(), right.answer.z);
    EXPECT_TRUE(agree(problem, right, wrong)) << set;
    wrong.answer.velocity += 1e-3 * problem.contact()->v;
    EXPECT_FALSE(agree(problem, right, wrong)) << set;
    wrong.answer.velocity(0) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(agree(problem, right, wrong)) << set;
  }
}

TEST(VelocityAgreementTest, AppliesWhereTheoryHasOneVelocityOnly) {
  EXPECT_FALSE(VelocityAgreement::applies(open_set("paper/copositive/exp1")->generate(1, 0), true));
  EXPECT_FALSE(VelocityAgreement::applies(open_set("planted/definite{form=lcp}")->generate(1, 0), true));
  EXPECT_FALSE(VelocityAgreement::applies(open_set("paper/monotone/exp3")->generate(1, 0), false));
}

}  // namespace
}  // namespace lcpbench::velocity_agreement_test
