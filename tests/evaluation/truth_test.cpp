#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/answer/farkas.h"
#include "tests/support/evaluation_cases.h"

namespace lcpbench::truth_test {
namespace {

TEST(TruthTest, SoftContactsAreSolvableOnlyIfTheGivenInverseIsSemidefinite) {
  const auto truth_of = [](double last) {
    Matrix Ginv = Matrix::Ones(2, 2);
    Ginv(1, 1) = last;
    ContactProblem contact = frictionless(vec({-1, 0}), Matrix(vec({1, -1})), InverseInertia{Ginv});
    contact.compliance_n = vec({1e-20});
    return Evaluator(Problem("soft", contact)).truth();
  };
  EXPECT_EQ(truth_of(1), Truth::kSolvable);
  EXPECT_EQ(truth_of(1 - 0x1p-53), Truth::kUnknown);  // M = 1e-20 - 2^-53 and q = -1: no solution
}

TEST(TruthTest, PositiveDefiniteInertiaMakesAContactProblemSolvable) {
  EXPECT_EQ(Evaluator(sliding_particle()).truth(), Truth::kSolvable);
  Draw draw(11);
  const Matrix N = draw.matrix(3, 5);  // redundant contacts change nothing
  const Matrix X = draw.matrix(3, 3);
  const Vector v = draw.vector(3);
  EXPECT_EQ(Evaluator(Problem("full", frictionless(v, N, FactoredInertia{X, vec({1, 2, 3})}))).truth(),
            Truth::kSolvable);
  EXPECT_EQ(Evaluator(Problem("G*", frictionless(v, N, InverseInertia{Matrix::Identity(3, 3)}))).truth(),
            Truth::kSolvable);
  EXPECT_EQ(Evaluator(Problem("reduced", frictionless(v, N, FactoredInertia{X.leftCols(2), vec({1, 2})}))).truth(),
            Truth::kUnknown);
  Matrix dependent = X;
  dependent.col(2) = dependent.col(0) + dependent.col(1);
  EXPECT_EQ(Evaluator(Problem("dependent", frictionless(v, N, FactoredInertia{dependent, vec({1, 2, 3})}))).truth(),
            Truth::kUnknown);
  ContactProblem negative_mu = *sliding_particle().contact();
  negative_mu.mu(0) = -0.5;
  EXPECT_EQ(Evaluator(Problem("mu", negative_mu)).truth(), Truth::kUnknown);
}

TEST(TruthTest, NothingIsKnownOfDataThatAreNotFinite) {
  const auto truth = [](const ContactProblem& problem) { return Evaluator(Problem("not finite", problem)).truth(); };
  const ContactProblem finite = *sliding_particle().contact();
  ASSERT_EQ(truth(finite), Truth::kSolvable);
  ContactProblem changed = finite;
  std::get<Matrix>(changed.N)(0, 0) = kNan;
  EXPECT_EQ(truth(changed), Truth::kUnknown);
  changed = finite;
  changed.mu(0) = kInf;
  EXPECT_EQ(truth(changed), Truth::kUnknown);
  changed = finite;
  changed.compliance_n = vec({kInf});
  EXPECT_EQ(truth(changed), Truth::kUnknown);
}

TEST(TruthTest, ABareLcpIsSolvableWhenItsMatrixIsProvenPositiveDefinite) {
  Matrix M(2, 2);
  M << 1, 5, -5, 1;
  EXPECT_EQ(Evaluator(Problem("PD", Lcp{M, vec({-1, -1})})).truth(), Truth::kSolvable);
  M << 1, 1, 1, 1;
  EXPECT_EQ(Evaluator(Problem("PSD", Lcp{M, vec({-1, -1})})).truth(), Truth::kUnknown);
  EXPECT_EQ(Evaluator(Problem("large", Lcp{Matrix::Identity(65, 65), Vector::Ones(65)})).truth(), Truth::kUnknown);
}

// Two contacts push along x against each other and up together; nothing has inertia along y.
Problem squeezed(double vx, double vy) {
  Matrix N(2, 2);
  N << 1, -1, 1, 1;
  return Problem("squeezed", frictionless(vec({vx, vy}), N, FactoredInertia{Matrix(vec({1, 0})), vec({2})}));
}

TEST(FarkasTest, AProofHoldsAndOverridesASmallResidual) {
  const Problem problem = squeezed(0x1p-40, -0x1p-20);
  const Evaluator evaluator(problem);
  EXPECT_TRUE(evaluator.check_farkas(vec({1, 1})));
  EXPECT_TRUE(evaluator.check_farkas(vec({0x1p-1000, 0x1p-1000})));
  EXPECT_EQ(evaluator.truth(), Truth::kUnknown);
  Errors looks_solved;
  looks_solved.solved = true;
  EXPECT_EQ(verdict(Claim::kSolved, looks_solved, Truth::kUnsolvable), Verdict::kWrong);
  EXPECT_EQ(verdict(Claim::kIterationLimit, looks_solved, Truth::kUnsolvable), Verdict::kUnsolvable);
}

TEST(FarkasTest, WhatIsNotExactlyAProofIsNone) {
  const Evaluator evaluator(squeezed(0, -1));
  EXPECT_FALSE(evaluator.check_farkas(vec({1, 1 + 0x1p-52})));  // equal only to rounding
  EXPECT_FALSE(evaluator.check_farkas(vec({1, 0})));
  EXPECT_FALSE(evaluator.check_farkas(vec({0, 0})));
  EXPECT_FALSE(evaluator.check_farkas(vec({-1, -1})));
  EXPECT_FALSE(evaluator.check_farkas(vec({kNan, 1})));
  EXPECT_FALSE(evaluator.check_farkas(vec({kInf, kInf})));
  EXPECT_FALSE(evaluator.check_farkas(vec({1})));
  EXPECT_FALSE(evaluator.check_farkas(Vector()));
  EXPECT_FALSE(Evaluator(squeezed(0, 1)).check_farkas(vec({1, 1})));  // parting: solvable
  EXPECT_FALSE(Evaluator(squeezed(0, 1)).check_farkas(vec({-1, -1})));
  EXPECT_FALSE(Evaluator(squeezed(0, 0)).check_farkas(vec({1, 1})));
}

TEST(FarkasTest, SumsThatDoubleArithmeticLosesAreKept) {
  Matrix N(2, 3);
  N << 1, 0x1p-80, -1, 1, 1, 1;  // in double the first row sums to zero
  const FactoredInertia along_x{Matrix(vec({1, 0})), vec({1})};
  EXPECT_FALSE(Evaluator(Problem("lost", frictionless(vec({0, -1}), N, along_x))).check_farkas(vec({1, 1, 1})));
  N(0, 1) = 0;
  EXPECT_TRUE(Evaluator(Problem("kept", frictionless(vec({0, -1}), N, along_x))).check_farkas(vec({1, 1, 1})));
  N << 0x1p1000, 0, -0x1p1000, 0x1p-1000, 0x1p-1000, 0x1p-1000;
  EXPECT_TRUE(
      Evaluator(Problem("far", frictionless(vec({0, -0x1p-1000}), N, along_x))).check_farkas(vec({1, 0x1p-1070, 1})));
}

TEST(FarkasTest, EveryFormOfTheInertiaHasItsNullSpace) {
  Matrix N(2, 2);
  N << 1, -1, 1, 1;
  const Vector v = vec({0, -1});
  Matrix along_x = Matrix::Zero(2, 2);
  along_x(0, 0) = 2;
  const auto proven = [&](Inertia inertia) {
    return Evaluator(Problem("p", frictionless(v, N, std::move(inertia)))).check_farkas(vec({1, 1}));
  };
  EXPECT_TRUE(proven(DenseInertia{along_x}));
  EXPECT_TRUE(proven(InverseInertia{along_x}));
  EXPECT_TRUE(proven(BlockInertia{{Matrix::Constant(1, 1, 2), Matrix::Zero(1, 1)}}));
  EXPECT_FALSE(proven(DenseInertia{Matrix::Identity(2, 2)}));
  EXPECT_FALSE(proven(BlockInertia{{Matrix::Constant(1, 1, 2), Matrix::Constant(1, 1, 0x1p-1000)}}));
  EXPECT_FALSE(proven(FactoredInertia{Matrix::Identity(2, 2), vec({1, 1})}));
}

// z_1 - z_2 >= 1 + 1e-7 and z_2 - z_1 >= -1: both c_i are 2 and both F_i 1 + 1e-7, so that u = (1, 1) misses by
// 1e-7 / (2 + 2e-7). Of 0 z >= 1 nothing but the floor 1 counts. The tolerance is the rounding of the data.
TEST(FarkasTest, TheMarginOfAProofIsRelativeToTheProblemsOwnFloors) {
  const Lcp close{Matrix{{1.0, -1.0}, {-1.0, 1.0}}, Vector{{-1 - 1e-7, 1.0}}};
  ASSERT_TRUE(proves_unsolvable(close, Vector{{1, 1}}));
  EXPECT_NEAR(proof_margin(close, Vector{{1, 1}}), 1e-7 / (2 + 2e-7), 1e-15);
  const Lcp clear{Matrix{{0.0}}, Vector{{-1.0}}};
  EXPECT_EQ(proof_margin(clear, Vector{{3.0}}), 1);
}

TEST(FarkasTest, BareProblemsAreProvenFromTheirMatrix) {
  Matrix M(2, 2);
  M << 1, -1, -1, 1;
  EXPECT_TRUE(Evaluator(Problem("crushed", Lcp{M, vec({-1, -1})})).check_farkas(vec({1, 1})));
  EXPECT_FALSE(Evaluator(Problem("barely", Lcp{M, vec({-1, 1 + 0x1p-40})})).check_farkas(vec({1, 1})));
  EXPECT_FALSE(Evaluator(Problem("crushed", Lcp{M, vec({-1, -1})})).check_farkas(vec({1, 2})));
  M << 0, 1, -1, 0;
  EXPECT_TRUE(Evaluator(Problem("transposed", Lcp{M, vec({1, -1})})).check_farkas(vec({0, 1})));
  EXPECT_FALSE(Evaluator(Problem("transposed", Lcp{M, vec({-1, 1})})).check_farkas(vec({1, 0})));
}

}  // namespace
}  // namespace lcpbench::truth_test
