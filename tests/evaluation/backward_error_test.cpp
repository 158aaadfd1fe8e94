#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/answer/contact_lcp.h"
#include "core/answer/lcp_error.h"
#include "tests/support/evaluation_cases.h"

namespace lcpbench::backward_error_test {
namespace {

// As the definition spells it, for a problem of one block.
Quad plain_error(const Lcp& lcp, const Vector& z) {
  Quad worst = 0;
  for (Index i = 0; i < z.size(); ++i) {
    Quad c = 0;
    Quad w = lcp.q(i);
    for (Index j = 0; j < z.size(); ++j) {
      c += abs(Quad{lcp.M(i, j)});
      w += Quad{lcp.M(i, j)} * z(j);
    }
    if (c == 0) c = 1;
    const Quad violation = abs(std::min(c * z(i), w));
    if (violation > 0) worst = std::max(worst, violation / (abs(Quad{lcp.q(i)}) + c * z.cwiseAbs().maxCoeff()));
  }
  return worst;
}

void expect_close(double found, Quad expected, const std::string& what) {
  const double reference = to_double(expected);
  if (std::isinf(reference)) {
    EXPECT_EQ(found, reference) << what;
  } else {
    EXPECT_NEAR(found, reference, 1e-15 * reference + 1e-30) << what;
  }
}

TEST(BackwardErrorTest, IsThatOfTheDefinition) {
  Draw draw(7);
  for (int trial = 0; trial < 60; ++trial) {
    const ContactProblem contact = random_frictional(draw, 3, 1 + trial % 3, 4);
    const Lcp lcp = form_lcp(contact);
    Vector z = random_answer(draw, lcp.size());
    if (trial % 3 == 0) z = z.cwiseAbs();
    const Errors by_contact = evaluate(Problem("contact", contact), z);
    const Errors by_matrix = evaluate(Problem("matrix", lcp), z);
    expect_close(by_matrix.backward_row_norm, plain_error(lcp, z), "trial " + std::to_string(trial));
    EXPECT_TRUE(std::isnan(by_contact.backward_row_norm));
    EXPECT_NEAR(by_contact.natural_residual, by_matrix.natural_residual, 1e-15 * by_matrix.natural_residual);
    EXPECT_NEAR(by_contact.complementarity_j, by_matrix.complementarity_j,
                1e-15 * by_matrix.natural_residual * z.lpNorm<1>() + 1e-15 * std::abs(by_matrix.complementarity_j));
  }
}

TEST(QuadLcpTest, EveryWayToARowGivesTheSameRow) {
  Draw draw(13);
  const ContactProblem contact = random_frictional(draw, 5, 4, 6);
  const Lcp dense = form_lcp(contact);
  const RefinedInertia inertia(contact.inertia);
  ContactLcp lcp(contact, inertia);
  const Vector answer_z = random_answer(draw, dense.size());
  const QuadVector z(answer_z.begin(), answer_z.end());
  const QuadVector u = lcp.response(z);
  const QuadVector w = lcp.all_rows(z, u);
  const QuadVector expected = lcp_error<Quad>(dense, z).w;
  for (std::size_t i = 0; i < lcp.size(); ++i) {
    EXPECT_LT(std::abs(to_double(w[i] - expected[i])), 1e-30);
    const double diagonal = dense.M(static_cast<Index>(i), static_cast<Index>(i));
    EXPECT_LT(std::abs(to_double(lcp.diagonal(i) - Quad{diagonal})), 0x1p-30 * diagonal + 1e-30);
  }
}

Errors errors_of(const Matrix& M, const Vector& q, const Vector& z) { return evaluate(Problem("lcp", Lcp{M, q}), z); }

TEST(BackwardErrorTest, WhatAnInteriorPointLeavesInABlockAtRestPasses) {
  const Matrix M{{2, 1}, {1, 3}};
  const Errors dust = errors_of(M, vec({4, 5}), vec({2.5e-12, 1e-12}));
  EXPECT_TRUE(dust.solved);
  EXPECT_NEAR(dust.backward_row_norm, 3 * 2.5e-12 / 4, 1e-22);
  EXPECT_TRUE(errors_of(M, vec({4, 5}), vec({0, 0})).solved);
  EXPECT_FALSE(errors_of(M, vec({4, 5}), vec({1e-3, 0})).solved);
  // Beside a block that does not rest, which has another scale.
  const Matrix apart{{2, 1, 0}, {1, 3, 0}, {0, 0, 4}};
  EXPECT_TRUE(errors_of(apart, vec({-4, -5, 7}), vec({1.4, 1.2, 8e-9})).solved);
  EXPECT_FALSE(errors_of(apart, vec({-4, -5, 7}), vec({1.4, 1.2, 8e-6})).solved);
}

TEST(BackwardErrorTest, ANegativeEntryCountsByItsSize) {
  const Matrix M{{1, 0.5}, {0.5, 1}};
  EXPECT_EQ(errors_of(M, vec({-1, 1}), vec({1, -0x1p-30})).backward_row_norm, 1.5 * 0x1p-30 / 2.5);
  EXPECT_TRUE(errors_of(M, vec({-1, 1}), vec({1, -1e-7})).solved);
  EXPECT_FALSE(errors_of(M, vec({-1, 1}), vec({1, -1e-5})).solved);
}

TEST(BackwardErrorTest, ARowOfZerosCountsZByItself) {
  const Matrix zero = Matrix::Zero(1, 1);
  EXPECT_EQ(errors_of(zero, vec({0}), vec({3})).backward_row_norm, 0);
  EXPECT_EQ(errors_of(zero, vec({0}), vec({-3})).backward_row_norm, 1);
  EXPECT_EQ(errors_of(zero, vec({-1}), vec({0})).backward_row_norm, 1);
  EXPECT_EQ(errors_of(zero, vec({1}), vec({1})).backward_row_norm, 0.5);
  EXPECT_EQ(errors_of(Matrix{{0, -1}, {0, 0}}, vec({0, 1}), vec({0, 0.5})).backward_row_norm, 1);  // w_0 = -z_1
}

// What docs/explanation/verdicts.md warns of: such an answer shows a problem that is nearly solvable.
TEST(BackwardErrorTest, ASmallRowHidesAWrongEntry) {
  const Matrix M{{1, 1}, {0, 1}};
  EXPECT_TRUE(errors_of(M, vec({-1e8, -1}), vec({1e8 - 1, 1})).solved);
  EXPECT_TRUE(errors_of(M, vec({-1e8, -1}), vec({1e8, 0})).solved);  // z_1 is to be 1
  EXPECT_FALSE(errors_of(M, vec({-1e5, -1}), vec({1e5, 0})).solved);
}

TEST(BackwardErrorTest, AnotherBoundMayBeAskedFor) {
  const Matrix M = Matrix::Identity(1, 1);
  Errors errors = errors_of(M, vec({-1}), vec({1 + 2e-8}));
  EXPECT_TRUE(errors.solved);
  EXPECT_EQ(errors.limit, kSolvedBackwardError);
  errors.decide(1e-9);
  EXPECT_FALSE(errors.solved);
  Errors of_contact = evaluate(sliding_particle(), Vector::Zero(sliding_particle().size()));
  of_contact.decide(1);
  EXPECT_EQ(of_contact.solved, of_contact.measure() <= 1);
  Errors unmeasured;
  unmeasured.decide(1);
  EXPECT_FALSE(unmeasured.solved);
}

}  // namespace
}  // namespace lcpbench::backward_error_test
