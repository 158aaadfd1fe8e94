#include "study/evaluation/backward_error.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "study/evaluation/contact_lcp.h"
#include "tests/support/evaluation_cases.h"

namespace lcpbench {
namespace {

Quad plain_quotient(Quad value, Quad scale) {
  if (value == 0) return 0;
  return scale == 0 ? Quad{kInf} : value / scale;
}

// eta(z_tau) as the definition spells it.
Quad plain_eta(const Lcp& lcp, const Vector& z, Quad tau) {
  const Index n = lcp.size();
  const double largest = z.cwiseAbs().maxCoeff();
  std::vector<Quad> kept;
  Quad norm = 0;
  for (Index i = 0; i < n; ++i) {
    const Quad ratio = z(i) == 0 ? Quad{0} : abs(Quad{z(i)}) / largest;
    kept.push_back(ratio <= tau ? 0 : z(i));
    if (kept.back() < 0) return Quad{kInf};
    norm = std::max(norm, kept.back());
  }
  Quad eta = 0;
  for (Index i = 0; i < n; ++i) {
    Quad w = lcp.q(i);
    Quad scale = abs(Quad{lcp.q(i)});
    for (Index j = 0; j < n; ++j) {
      w += lcp.M(i, j) * kept[static_cast<std::size_t>(j)];
      scale += abs(Quad{lcp.M(i, j)}) * norm;
    }
    const Quad violation = kept[static_cast<std::size_t>(i)] > 0 ? abs(w) : std::max(Quad{0}, -w);
    eta = std::max(eta, plain_quotient(violation, scale));
  }
  return eta;
}

Quad plain_mixed_error(const Lcp& lcp, const Vector& z) {
  Quad best = kInf;
  const auto offer = [&](Quad tau) { best = std::min(best, std::max(tau, plain_eta(lcp, z, tau))); };
  offer(0);
  for (int step = -240; step <= 4; ++step) offer(std::exp2(step / 4.0));
  for (Index i = 0; i < z.size(); ++i) {
    if (z(i) != 0) offer(abs(Quad{z(i)}) / z.cwiseAbs().maxCoeff());
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
    const Lcp lcp = form_lcp(contact);
    Vector z = random_answer(draw, lcp.size());
    if (trial % 3 == 0) z = z.cwiseAbs();
    const Errors by_contact = evaluate(Problem("contact", contact), z);
    const Errors by_matrix = evaluate(Problem("matrix", lcp), z);
    expect_close(by_matrix.backward_row_norm, plain_mixed_error(lcp, z), "trial " + std::to_string(trial));
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
  const QuadVector expected = complement(dense, z);
  for (std::size_t i = 0; i < lcp.size(); ++i) {
    EXPECT_LT(std::abs(to_double(w[i] - expected[i])), 1e-30);
    const double diagonal = dense.M(static_cast<Index>(i), static_cast<Index>(i));
    EXPECT_LT(std::abs(to_double(lcp.diagonal(i) - Quad{diagonal})), 0x1p-30 * diagonal + 1e-30);
  }
}

TEST(BackwardErrorTest, ForgivesDustAtThePriceOfItsSize) {
  Lcp lcp{Matrix::Identity(2, 2), vec({-1, 1})};
  lcp.M(0, 1) = lcp.M(1, 0) = 0.5;
  const Errors errors = evaluate(Problem("dust", lcp), vec({1, 1e-12}));  // w_2 = 1.5: not complementary
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
  EXPECT_EQ(evaluate(Problem("0/0", lcp), vec({3})).backward_row_norm, 0);
  Lcp coupled{Matrix::Zero(2, 2), vec({0, 1})};
  coupled.M(0, 1) = -1;  // z = (0, t): w_0 = -t with s_0 = t
  EXPECT_EQ(evaluate(Problem("-t", coupled), vec({0, 0.5})).backward_row_norm, 1);
}

}  // namespace
}  // namespace lcpbench
