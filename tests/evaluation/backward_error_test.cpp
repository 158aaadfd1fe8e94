#include "study/evaluation/backward_error.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/evaluation_cases.h"

namespace lcpbench {
namespace {

Quad plain_quotient(Quad value, Quad scale) {
  if (value == 0) return 0;
  return scale == 0 ? Quad{kInf} : value / scale;
}

// eta(z_tau) as the definition spells it, from the whole of M.
Quad plain_eta(const Lcp& lcp, const Vector& z, Index lambda_offset, Quad tau, BackwardScale kind) {
  const Index n = lcp.size();
  const auto largest = [&](Index begin, Index count) {
    return count == 0 ? 0 : z.segment(begin, count).cwiseAbs().maxCoeff();
  };
  const double impulse = largest(0, lambda_offset);
  const double lambda = largest(lambda_offset, n - lambda_offset);
  std::vector<Quad> kept;
  Quad norm = 0;
  for (Index i = 0; i < n; ++i) {
    const Quad ratio = z(i) == 0 ? Quad{0} : abs(Quad{z(i)}) / (i < lambda_offset ? impulse : lambda);
    kept.push_back(ratio <= tau ? 0 : z(i));
    if (kept.back() < 0) return Quad{kInf};
    norm = std::max(norm, kept.back());
  }
  Quad eta = 0;
  for (Index i = 0; i < n; ++i) {
    Quad w = lcp.q(i);
    Quad scale = abs(Quad{lcp.q(i)});
    for (Index j = 0; j < n; ++j) {
      const Quad entry = lcp.M(i, j);
      const Quad z_j = kept[static_cast<std::size_t>(j)];
      w += entry * z_j;
      scale += abs(entry) * (kind == BackwardScale::kComponentwise ? z_j : norm);
    }
    const Quad violation = kept[static_cast<std::size_t>(i)] > 0 ? abs(w) : std::max(Quad{0}, -w);
    eta = std::max(eta, plain_quotient(violation, scale));
  }
  return eta;
}

enum class Taus { kRatios, kRatiosAndGrid };

Quad plain_mixed_error(const Lcp& lcp, const Vector& z, Index lambda_offset, BackwardScale kind,
                       Taus taus = Taus::kRatiosAndGrid) {
  Quad best = kInf;
  const auto offer = [&](Quad tau) {
    best = std::min(best, std::max(tau, plain_eta(lcp, z, lambda_offset, tau, kind)));
  };
  offer(0);
  for (int step = taus == Taus::kRatios ? 5 : -240; step <= 4; ++step) offer(std::exp2(step / 4.0));
  for (Index i = 0; i < z.size(); ++i) {
    const bool is_impulse = i < lambda_offset;
    const auto block = is_impulse ? z.head(lambda_offset) : z.tail(z.size() - lambda_offset);
    if (z(i) != 0) offer(abs(Quad{z(i)}) / block.cwiseAbs().maxCoeff());
  }
  return best;
}

void expect_close(double found, Quad expected, const std::string& what) {
  const double reference = to_double(expected);
  if (std::isinf(reference)) {
    EXPECT_EQ(found, reference) << what;
  } else {
    EXPECT_NEAR(found, reference, 1e-15 * reference + 1e-30) << what;
  }
}

TEST(BackwardErrorTest, IsTheMinimumOverAFineGridOfTau) {
  Draw draw(7);
  for (int trial = 0; trial < 60; ++trial) {
    const ContactProblem contact = random_frictional(draw, 3, 1 + trial % 3, 4);
    const Problem problem("contact", contact);
    const Lcp lcp = form_lcp(contact);
    const Index impulses = 5 * contact.nc();
    Vector z = random_answer(draw, lcp.size());
    if (trial % 3 == 0) z.head(impulses) = z.head(impulses).cwiseAbs();
    const Errors by_contact = evaluate(problem, z);
    const Errors by_matrix = evaluate(Problem("matrix", lcp), z);
    for (const BackwardScale kind : {BackwardScale::kComponentwise, BackwardScale::kRowNorm}) {
      const bool componentwise = kind == BackwardScale::kComponentwise;
      const std::string what = "trial " + std::to_string(trial) + (componentwise ? " componentwise" : " row norm");
      expect_close(componentwise ? by_contact.backward_componentwise : by_contact.backward_row_norm,
                   plain_mixed_error(lcp, z, impulses, kind), what + " contact");
      expect_close(componentwise ? by_matrix.backward_componentwise : by_matrix.backward_row_norm,
                   plain_mixed_error(lcp, z, lcp.size(), kind), what + " matrix");
    }
    EXPECT_NEAR(by_contact.natural_residual, by_matrix.natural_residual, 1e-15 * by_matrix.natural_residual);
    EXPECT_NEAR(by_contact.complementarity_j, by_matrix.complementarity_j,
                1e-15 * by_matrix.natural_residual * z.lpNorm<1>() + 1e-15 * std::abs(by_matrix.complementarity_j));
  }
}

TEST(BackwardErrorTest, IsTheMinimumOverAllRatiosWhereRowsAreChosenByEstimate) {
  Draw draw(12);
  for (int trial = 0; trial < 3; ++trial) {
    const ContactProblem contact = random_frictional(draw, 5, 10, 8);
    const Lcp lcp = form_lcp(contact);
    const Vector z = random_answer(draw, lcp.size()).cwiseAbs() + Vector::Constant(lcp.size(), 0x1p-60);
    const Errors by_contact = evaluate(Problem("contact", contact), z);
    const Errors by_matrix = evaluate(Problem("matrix", lcp), z);
    const auto expected = [&](Index lambda_offset, BackwardScale kind) {
      return plain_mixed_error(lcp, z, lambda_offset, kind, Taus::kRatios);
    };
    const std::string what = "trial " + std::to_string(trial);
    expect_close(by_contact.backward_componentwise, expected(90, BackwardScale::kComponentwise), what);
    expect_close(by_contact.backward_row_norm, expected(90, BackwardScale::kRowNorm), what);
    expect_close(by_matrix.backward_componentwise, expected(100, BackwardScale::kComponentwise), what);
    expect_close(by_matrix.backward_row_norm, expected(100, BackwardScale::kRowNorm), what);
  }
}

// By componentwise scale. The bound on the rounding is to leave nothing open.
void expect_backward_error_without_doubt(const ContactProblem& contact, const Vector& z, Quad expected) {
  const BoundedInertia inertia(contact.inertia);
  ContactLcp<Bounded> lcp(contact, inertia);
  const BoundedVector exact_z(z.begin(), z.end());
  const BoundedVector u = lcp.response(exact_z);
  const BoundedVector w = lcp.all_rows(exact_z, u);
  const IslandRows islands(row_islands(contact));
  const Bounded error = mixed_backward_error(lcp, exact_z, u, w, BackwardScale::kComponentwise, islands).error;
  EXPECT_LE(2 * error.error, 0x1p-40 * error.high) << contact.v(0);
  expect_close(error.high, expected, "v_0 = " + std::to_string(contact.v(0)));
}

// Row 0 is violated by 1e-25 once the impulses of 1e-1 and then of 1 are removed, which is less than what the roundings
// of the division by 3 leave of it.
TEST(BackwardErrorTest, WhatRemovedImpulsesLeaveBehindIsNoDoubt) {
  Matrix N = Matrix::Zero(3, 3);
  N(0, 0) = N(1, 1) = N(0, 2) = N(1, 2) = N(2, 2) = 1;
  for (const double v0 : {-1e-25, -1e-33, 0.0}) {
    const ContactProblem contact = frictionless(vec({v0, -0.3, 0.1}), N, DenseInertia{3 * Matrix::Identity(3, 3)});
    const Vector z = vec({0.1, 1, 0});
    const Quad expected = plain_mixed_error(form_lcp(contact), z, z.size(), BackwardScale::kComponentwise);
    expect_backward_error_without_doubt(contact, z, expected);
  }
}

// Four bodies in a row fall at one velocity and the last one hits the ground. Once the small impulses are removed, the
// relative velocity of the first two is the difference of equal sums, and nothing moves it.
TEST(BackwardErrorTest, BodiesOfEqualVelocityAreNoDoubt) {
  Draw draw(31);
  for (int trial = 0; trial < 50; ++trial) {
    const Vector direction = draw.vector(3).cwiseAbs() / 3 + Vector::Constant(3, 0.1);
    const Vector velocity = draw.vector(3) / 7 - Vector::Constant(3, 0.2);
    Matrix N = Matrix::Zero(12, 4);
    for (Index pair = 0; pair < 3; ++pair) {
      N.block(3 * pair, pair, 3, 1) = -direction;
      N.block(3 * pair + 3, pair, 3, 1) = direction;
    }
    N(10, 3) = 1;
    const ContactProblem contact =
        frictionless(velocity.replicate(4, 1), N, DenseInertia{3 * Matrix::Identity(12, 12)});
    const double q = velocity(1), ground = -3 * q * (1 + 1e-3);
    const Quad moved = Quad{ground} / 3;
    const Vector z = vec({1e-12, 2e-12, 3e-12, ground});
    expect_backward_error_without_doubt(contact, z, abs(q + moved) / (abs(Quad{q}) + moved));
  }
}

// q_0 = -2^-104 is known to 12 %, and no impulse moves the contact: it is violated by all of q_0.
TEST(BackwardErrorTest, ARowThatNothingMovesIsNoDoubt) {
  Matrix N = Matrix::Ones(5, 3);
  N.col(0) << 0.1, -0.1, 1 + 0x1p-52, -1, 0;
  N.col(1) << 0, 0, 0, 0, 1;
  expect_backward_error_without_doubt(
      frictionless(vec({0.3, 0.3, 1 - 0x1p-52, 1, -0.5}), N, DenseInertia{Matrix::Identity(5, 5)}), vec({0, 1, 0}), 1);
}

TEST(QuadLcpTest, EveryWayToARowGivesTheSameRow) {
  Draw draw(13);
  const ContactProblem contact = random_frictional(draw, 5, 4, 6);
  const Lcp dense = form_lcp(contact);
  const QuadInertia inertia(contact.inertia);
  ContactQuadLcp lcp(contact, inertia);
  BareQuadLcp bare(dense);
  const Vector answer_z = random_answer(draw, dense.size());
  const QuadVector z(answer_z.begin(), answer_z.end());
  QuadVector u = lcp.response(z);
  const QuadVector w = lcp.all_rows(z, u);
  const QuadVector expected = bare.response(z);
  std::vector<std::size_t> rows(lcp.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  const std::vector<double> estimated = lcp.estimate_w(z, u, rows);
  for (std::size_t i = 0; i < lcp.size(); ++i) {
    EXPECT_TRUE(lcp.row(i, z, u) == w[i]);
    EXPECT_LT(std::abs(to_double(w[i] - expected[i])), 1e-30);
    EXPECT_NEAR(estimated[i], to_double(w[i]), 1e-13);
    EXPECT_LT(std::abs(to_double(lcp.diagonal(i) - bare.diagonal(i))), 1e-30);
    EXPECT_LT(std::abs(to_double(lcp.abs_row_sum(i) - bare.abs_row_sum(i))), 1e-28);
    Vector row = Vector::Zero(dense.size());
    const MagnitudeEstimate::Row* estimated_row = lcp.estimated_row(i);
    ASSERT_NE(estimated_row, nullptr);
    for (std::size_t e = estimated_row->begin; e < estimated_row->end; ++e) {
      row(static_cast<Index>(lcp.estimate().columns[e])) = lcp.estimate().entries[e];
    }
    for (Index j = 0; j < dense.size(); ++j) {
      const std::size_t column = lcp.representative(static_cast<std::size_t>(j));
      EXPECT_LE(std::abs(row(static_cast<Index>(column)) - std::abs(dense.M(static_cast<Index>(i), j))),
                estimated_row->error * lcp.estimate().column_scale[column]);
    }
  }
  lcp.remove(7, z[7], u);
  QuadVector without = z;
  without[7] = 0;
  const QuadVector again = lcp.response(without);
  for (std::size_t r = 0; r < u.size(); ++r) EXPECT_LT(std::abs(to_double(u[r] - again[r])), 1e-30);
}

TEST(BackwardErrorTest, ForgivesDustAtThePriceOfItsSize) {
  Lcp lcp{Matrix::Identity(2, 2), vec({-1, 1})};
  lcp.M(0, 1) = lcp.M(1, 0) = 0.5;
  const Errors errors = evaluate(Problem("dust", lcp), vec({1, 1e-12}));  // w_2 = 1.5: not complementary
  EXPECT_EQ(errors.backward_componentwise, 1e-12);
  EXPECT_EQ(errors.backward_row_norm, 1e-12);
  EXPECT_TRUE(errors.solved);
  EXPECT_FALSE(evaluate(Problem("dust", lcp), vec({1, 1e-8})).solved);
  EXPECT_TRUE(evaluate(Problem("dust", lcp), vec({1, -1e-12})).solved);
  // Alone in its block it is the largest entry, and no dust.
  EXPECT_EQ(evaluate(Problem("alone", Lcp{Matrix::Identity(2, 2), vec({-1, 1})}), vec({1, 1e-12})).backward_row_norm,
            1);
}

TEST(BackwardErrorTest, ARowWithoutDataForgivesNothing) {
  const Lcp lcp{Matrix::Zero(1, 1), vec({0})};
  EXPECT_EQ(evaluate(Problem("0/0", lcp), vec({3})).backward_componentwise, 0);
  Lcp coupled{Matrix::Zero(2, 2), vec({0, 1})};
  coupled.M(0, 1) = -1;  // z = (0, t): w_0 = -t with s_0 = t
  EXPECT_EQ(evaluate(Problem("-t", coupled), vec({0, 0.5})).backward_componentwise, 1);
}

}  // namespace
}  // namespace lcpbench
