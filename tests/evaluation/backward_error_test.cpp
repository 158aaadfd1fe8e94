#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/answer/contact_lcp.h"
#include "core/answer/lcp_error.h"
#include "tests/support/evaluation_cases.h"

namespace lcpbench::backward_error_test {
namespace {

// As the definition spells it, for a problem of one block without rows of friction.
Quad plain_error(const Lcp& lcp, const Vector& z) {
  const auto n = static_cast<std::size_t>(z.size());
  const LcpBounds bounds = lcp.is_mixed() ? lcp.bounds : LcpBounds::nonnegative(z.size());
  QuadVector c(n, 0), w(n), terms(n), sizes(n);
  Quad largest = 0, largest_share = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = static_cast<Index>(i);
    w[i] = lcp.q(row);
    terms[i] = sizes[i] = abs(w[i]);
    for (Index j = 0; j < z.size(); ++j) {
      const Quad entry = lcp.M(row, j);
      c[i] += abs(entry);
      w[i] += entry * z(j);
      terms[i] += abs(entry * z(j));
      sizes[i] += abs(entry) * std::max({bounds.lower(j), -bounds.upper(j), 0.0});
    }
    if (c[i] == 0) c[i] = 1;
    largest = std::max(largest, sizes[i]);
    largest_share = std::max(largest_share, sizes[i] / c[i]);
  }
  Quad worst = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = static_cast<Index>(i);
    const Quad at = z(row);
    std::array three{c[i] * (at - bounds.lower(row)), c[i] * (at - bounds.upper(row)), w[i]};
    std::sort(three.begin(), three.end());
    const Quad floor = std::min(c[i] * largest_share, largest);
    if (three[1] != 0) worst = std::max(worst, abs(three[1]) / std::max(terms[i], floor / 100));
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

TEST(BackwardErrorTest, OfMixedLcpsIsThatOfTheDefinition) {
  Draw draw(17);
  for (int trial = 0; trial < 60; ++trial) {
    Lcp lcp = form_lcp(random_frictional(draw, 3, 1 + trial % 3, 4));
    lcp.bounds = LcpBounds::nonnegative(lcp.size());
    for (Index i = 0; i < lcp.size(); ++i) {
      if ((i + trial) % 3 != 1) lcp.bounds.lower(i) = (i + trial) % 3 == 0 ? -kInf : static_cast<double>(i % 5 - 2);
      if (i % 2 == 0) lcp.bounds.upper(i) = std::max(lcp.bounds.lower(i), -2.0) + static_cast<double>(i % 3);
    }
    const Vector z = random_answer(draw, lcp.size());
    expect_close(evaluate(Problem("mixed", lcp), z).backward_row_norm, plain_error(lcp, z), std::to_string(trial));
  }
}

Errors errors_of(const Matrix& M, const Vector& q, const Vector& z) { return evaluate(Problem("lcp", Lcp{M, q}), z); }

// c = (3, 4) and Q = (4, 5), so that the largest Q_k / c_k is 4/3, and F = (4, 5).
TEST(BackwardErrorTest, OfAProblemByHand) {
  const Matrix M{{2, 1}, {1, 3}};
  const Vector q = vec({-4, 5});
  EXPECT_EQ(errors_of(M, q, vec({2, 0})).backward_row_norm, 0);               // w = (0, 7)
  EXPECT_EQ(errors_of(M, q, vec({2, 0.25})).backward_row_norm, 1 / 7.75);     // w = (0.25, 7.75): row 1 has c z = 1
  EXPECT_EQ(errors_of(M, q, vec({2.125, 0})).backward_row_norm, 0.25 / 8.25);  // w = (0.25, 7.125)
  EXPECT_EQ(errors_of(M, q, vec({0, 0})).backward_row_norm, 1);               // w_0 = -4 of |q_0| = 4
  EXPECT_EQ(errors_of(M, q, vec({2, -0.25})).backward_row_norm, 1 / 7.75);    // w = (-0.25, 6.25); c z = -1
}

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
  EXPECT_EQ(errors_of(M, vec({-1, 1}), vec({1, -0x1p-30})).backward_row_norm, 1.5 * 0x1p-30 / (1.5 + 0x1p-30));
  EXPECT_TRUE(errors_of(M, vec({-1, 1}), vec({1, -1e-7})).solved);
  EXPECT_FALSE(errors_of(M, vec({-1, 1}), vec({1, -1e-5})).solved);
}

TEST(BackwardErrorTest, ARowOfZerosCountsZByItself) {
  const Matrix zero = Matrix::Zero(1, 1);
  EXPECT_EQ(errors_of(zero, vec({0}), vec({3})).backward_row_norm, 0);
  EXPECT_EQ(errors_of(zero, vec({0}), vec({-3})).backward_row_norm, kInf);  // nothing has a size there
  EXPECT_EQ(errors_of(zero, vec({-1}), vec({0})).backward_row_norm, 1);
  EXPECT_EQ(errors_of(zero, vec({1}), vec({0.5})).backward_row_norm, 0.5);
  EXPECT_EQ(errors_of(Matrix{{0, -1}, {0, 0}}, vec({0, 1}), vec({0, 0.5})).backward_row_norm, 1);  // w_0 = -z_1
}

// z_1 <= 1 and z_1 >= 2: half of a unit is missing in rows of 2.5 and 3.5 units, however large the other two are.
TEST(BackwardErrorTest, AHugeMultiplierHidesNothing) {
  const Matrix M{{0, 1, -1}, {-1, 0, 0}, {1, 0, 0}};
  for (const double size : {0.0, 1.0, 1e7, 1e300}) {
    const Errors errors = errors_of(M, vec({0, 1, -2}), vec({1.5, size, size}));
    EXPECT_EQ(errors.backward_row_norm, 0.2);
    EXPECT_FALSE(errors.solved);
  }
  const Matrix upper{{1, 1}, {0, 1}};
  EXPECT_TRUE(errors_of(upper, vec({-1e8, -1}), vec({1e8 - 1, 1})).solved);
  EXPECT_FALSE(errors_of(upper, vec({-1e8, -1}), vec({1e8, 0})).solved);  // z_1 is to be 1
}

// Q / c = (1e-9 / 2, 1/3), so that F = (2/3, 1).
TEST(BackwardErrorTest, ARowOfSmallNumbersIsMeasuredByThoseBesideIt) {
  const Errors errors = errors_of(Matrix{{1, 1}, {1, 2}}, vec({-1e-9, 1}), vec({0, 0}));
  EXPECT_DOUBLE_EQ(errors.backward_row_norm, 1e-9 * 100 / (2.0 / 3));
  EXPECT_TRUE(errors.solved);
  // But by its own entries where these are small, too: F_0 = c_0.
  const Matrix M{{0x1p-20, 0x1p-20}, {0, 1}};
  EXPECT_DOUBLE_EQ(errors_of(M, vec({-0x1p-30, 1}), vec({0, 0})).backward_row_norm, 100 * 0x1p-11);
  // And what M does not connect it with does not matter.
  EXPECT_EQ(errors_of(Matrix::Identity(2, 2), vec({-1e-9, 1}), vec({0, 0})).backward_row_norm, 1);
}

Lcp with_bounds(const Matrix& M, const Vector& q, const Vector& lower, const Vector& upper) {
  Lcp lcp{M, q, LcpBounds::nonnegative(q.size())};
  lcp.bounds.lower = lower;
  lcp.bounds.upper = upper;
  return lcp;
}

// p = (0, +-100), Q = (1e-9, 100), Q / c = (1e-9, 50), so that F_0 = 50.
TEST(BackwardErrorTest, TheNearestNumbersWithinTheBoundsAreOfTheProblem) {
  const Matrix M{{1, 0}, {1, 1}};
  const Vector q = vec({-1e-9, 0});
  const Problem above("above", with_bounds(M, q, vec({0, 100}), vec({kInf, kInf})));
  EXPECT_DOUBLE_EQ(evaluate(above, vec({0, 100})).backward_row_norm, 1e-9 * 100 / 50);
  EXPECT_EQ(evaluate(above, vec({1e-9, 100})).backward_row_norm, 0);
  EXPECT_EQ(evaluate(above, vec({0, 200})).backward_row_norm, 1);  // w_1 = 200 away from the bound
  const Problem below("below", with_bounds(M, q, vec({0, -kInf}), vec({kInf, -100})));
  EXPECT_DOUBLE_EQ(evaluate(below, vec({0, -100})).backward_row_norm, 1e-9 * 100 / 50);
}

TEST(BackwardErrorTest, BoundsThatCrossByRoundingAreTakenInEitherOrder) {
  Lcp lcp = with_bounds(Matrix::Identity(2, 2), vec({1, 0}), vec({0, -kInf}), vec({kInf, kInf}));
  lcp.bounds.friction_of[1] = 0;
  lcp.bounds.mu(1) = 0.5;
  const Vector z = vec({-0x1p-40, 0});
  const double normal = 0x1p-40 / (1 + 0x1p-40);
  EXPECT_DOUBLE_EQ(evaluate(Problem("at rest", lcp), z).backward_row_norm, normal);
  lcp.q(1) = 1;  // c (z_1 - 2^-41), c (z_1 + 2^-41) and w_1 = 1
  const LcpError<Quad> error = lcp_error<Quad>(lcp, {z.begin(), z.end()});
  EXPECT_DOUBLE_EQ(to_double(error.backward), normal);
  EXPECT_EQ(error.row, 0);
  EXPECT_TRUE(lcp_residual<Quad>(lcp, 1, {z.begin(), z.end()}, 1, 1) == 0x1p-41);
}

TEST(BackwardErrorTest, WhatIsNoNumberIsNoSolution) {
  const Lcp lcp{Matrix::Identity(2, 2), vec({1, 1})};
  EXPECT_EQ(lcp_error<double>(lcp, {0, kNan}).backward, kInf);
  EXPECT_EQ(lcp_error<double>(Lcp{Matrix{{1, -1}, {0, 1}}, vec({1, 1})}, {kInf, kInf}).backward, kInf);
  EXPECT_EQ(lcp_error<double>(lcp, {0, 0}).backward, 0);
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
