#include "native/contact_lemke/contact_farkas.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {
SolverDefinition lcpbench_solver_active_set();
SolverDefinition lcpbench_solver_auto();
}  // namespace lcpbench

namespace lcpbench::contact_farkas_test {
namespace {

constexpr double kNoDeadline = std::numeric_limits<double>::infinity();

bool proves_unsolvable(const ContactProblem& contact) {
  ContactFarkas farkas;
  farkas.load(contact);
  return farkas.proves_unsolvable(contact.v, kNoDeadline);
}

/// Two contacts without friction on an inertia that only the first coordinate has.
ContactProblem on_one_factor(const Vector& second_normal) {
  ContactProblem contact;
  contact.v = Vector{{-1, 1}};
  Matrix N(2, 2);
  N << Vector{{1, 0.375}}, second_normal;
  contact.N = N;
  contact.D = Matrix(2, 0);
  contact.edges = {0, 0};
  contact.mu = Vector::Zero(2);
  contact.inertia = FactoredInertia{Matrix{{1.0}, {0.0}}, Vector::Ones(1)};
  return contact;
}

// The answer misses by 2e-6 of the scale.
TEST(ContactFarkasTest, ProvesThatAProblemOfThePaperHasNoSolution) {
  const Problem problem = open_set("paper/monotone/exp3")->generate(1, 4860);
  EXPECT_TRUE(proves_unsolvable(*problem.contact()));
}

TEST(ContactFarkasTest, RegularFactorsReachEveryVelocity) {
  ContactProblem contact = on_one_factor(Vector{{0, -1}});  // approaches with 1 m/s, and cannot be moved
  EXPECT_TRUE(proves_unsolvable(contact));
  contact.inertia = FactoredInertia{Matrix{{1, 1}, {0, 1}}, Vector::Ones(2)};
  EXPECT_FALSE(proves_unsolvable(contact));
}

TEST(ContactFarkasTest, WallsThatCloseInAreUnsolvableAtAnyInertia) {
  ContactProblem contact;
  contact.v = Vector{{0.5, 3}};
  contact.N = Matrix{{1, -1}, {0, 0}};
  contact.D = Matrix(2, 0);
  contact.edges = {0, 0};
  contact.mu = Vector::Zero(2);
  contact.inertia = DenseInertia{Matrix{{2, 1}, {1, 2}}};
  contact.b = Vector{{1, -1 - 1e-4}};
  EXPECT_TRUE(proves_unsolvable(contact));
  contact.b = Vector{{1, -1}};
  EXPECT_FALSE(proves_unsolvable(contact));
}

TEST(ContactFarkasTest, WhatYieldsProvesNothing) {
  ContactProblem contact = on_one_factor(Vector{{0, -1}});
  contact.compliance_n = Vector{{0, 0x1p-1000}};
  EXPECT_FALSE(proves_unsolvable(contact));
}

TEST(ContactFarkasTest, ProvesNothingAfterTheDeadline) {
  const ContactProblem contact = on_one_factor(Vector{{0, -1}});
  ContactFarkas farkas;
  farkas.load(contact);
  EXPECT_FALSE(farkas.proves_unsolvable(contact.v, wall_clock_s()));
}

TEST(ContactFarkasTest, WritesAProofInSmallIntegers) {
  ContactProblem contact = on_one_factor(Vector{{-2, -1}});
  contact.v = Vector{{-1, 1}};
  ContactFarkas farkas;
  farkas.load(contact);
  ASSERT_TRUE(farkas.proves_unsolvable(contact.v, kNoDeadline));
  EXPECT_EQ(farkas.proof(), (Vector{{2, 1}}));  // N u = (0, -0.25)
  EXPECT_TRUE(Evaluator(Problem("integers", contact)).check_farkas(farkas.proof()));
}

/// Two normals add up to the last coordinate, which no impulse moves.
ContactProblem opposite_contacts(double mu, double last_speed) {
  ContactProblem contact;
  contact.v = Vector{{0, 2, 0, 2, last_speed}};
  contact.N = Matrix{{0.3256340026855469, -0.3256340026855469},
                     {0.056557655334472656, -0.056557655334472656},
                     {-0.7966337203979492, 0.7966337203979492},
                     {0.6005973815917969, -0.6005973815917969},
                     {1.3582391738891602, -0.35823917388916016}};
  const Vector first{{-0.553863525390625, -0.1972799301147461, 0.44847965240478516, 0.940272331237793,  //
                      -0.3218822479248047}};
  const Vector second{
      {0.9038028717041016, 0.023614883422851562, -0.23888874053955078, -0.4565420150756836, -0.9629716873168945}};
  Matrix D(5, 4);
  D << first, -first, second, -second;
  contact.D = D;
  contact.edges = {2, 2};
  contact.mu = Vector{{mu, 0}};
  const Matrix X{{0, 0, 1}, {-2, -1, 2}, {-1, 1, 0}, {0, 1, 1}, {0, 0, 0}};
  contact.inertia = FactoredInertia{X, Vector::Ones(3)};
  return contact;
}

TEST(ContactFarkasTest, LargeFrictionDoesNotHideAMiss) {
  for (int exponent = 0; exponent <= 100; exponent += 2) {
    const double mu = std::ldexp(1.0, exponent);
    for (const double speed : {-1e-5, -1.0}) {
      EXPECT_TRUE(proves_unsolvable(opposite_contacts(mu, speed))) << exponent << " " << speed;
    }
    EXPECT_FALSE(proves_unsolvable(opposite_contacts(mu, 1))) << exponent;
  }
}

/// Contacts without friction on factors of weight one.
ContactProblem on_factors(const Matrix& X, const Matrix& N, const Vector& v) {
  ContactProblem contact;
  contact.v = v;
  contact.N = N;
  contact.D = Matrix(v.size(), 0);
  contact.edges.assign(static_cast<std::size_t>(N.cols()), 0);
  contact.mu = Vector::Zero(N.cols());
  contact.inertia = FactoredInertia{X, Vector::Ones(X.cols())};
  return contact;
}

// X'N = 2^-104: the contact can be moved, if only by an enormous impulse.
TEST(ContactFarkasTest, AProductOfTwoUlpsIsNotNothing) {
  const double ulp = 0x1p-52;
  const Matrix X{{1 + ulp}, {1}, {0}};
  const Vector v{{0, 0, -1}};
  EXPECT_FALSE(proves_unsolvable(on_factors(X, Matrix{{-(1 - ulp)}, {1}, {1}}, v)));
  EXPECT_TRUE(proves_unsolvable(on_factors(X, Matrix{{-1}, {1 + ulp}, {1}}, v)));
  EXPECT_TRUE(proves_unsolvable(on_factors(Matrix{{1}, {1}, {0}}, Matrix{{-1}, {1}, {0x1p-1000}}, v)));
}

// (1 + 2^-27)^2 is rounded down by 2^-54, so that N'v is -2^-55 in double, and 2^-55 in truth.
TEST(ContactFarkasTest, RoundingInDoubleIsNoApproach) {
  const Matrix X{{1}, {0}, {0}, {0}};
  const Matrix N{{0}, {1 + 0x1p-27}, {1}, {1}};
  const auto with_last = [&](double speed) {
    return on_factors(X, N, Vector{{0, 1 + 0x1p-27, -(1 + 0x1p-26), speed}});
  };
  EXPECT_FALSE(proves_unsolvable(with_last(-0x1p-55)));
  EXPECT_TRUE(proves_unsolvable(with_last(-1e-8)));
}

/// Three factors in a plane. u = (3, 7, 5) of the normals add up to what no factor meets.
ContactProblem three_in_a_plane() {
  const Matrix X{{1, 2, 3}, {-1, 1, 0}, {2, 1, 3}, {0, 0, 0}};
  const Matrix N{{5, -5, 5}, {1, 1, -3}, {-4, 1, 0}, {-1, -1, -1}};
  return on_factors(X, N, Vector{{0, 0, 0, 1}});
}

// X'N has three rows of rank two: the third counts as well, to the last bit.
TEST(ContactFarkasTest, DependentFactorsMustDependExactly) {
  EXPECT_TRUE(proves_unsolvable(three_in_a_plane()));
  for (const int exponent : {-30, 30}) {
    ContactProblem scaled = three_in_a_plane();
    Matrix& X = std::get<FactoredInertia>(scaled.inertia).X;
    X.col(2) *= std::ldexp(1.0, exponent);
    EXPECT_TRUE(proves_unsolvable(scaled)) << exponent;
  }
  for (Index k = 0; k < 3; ++k) {
    ContactProblem missed = three_in_a_plane();
    double& entry = std::get<FactoredInertia>(missed.inertia).X(0, k);
    entry = std::nextafter(entry, 10);
    EXPECT_FALSE(proves_unsolvable(missed)) << k;
  }
}

/// Pins around a disc, each nearly opposite to another, in holes that are too tight.
ContactProblem tight_pins(int pairs) {
  ContactProblem contact;
  const Index nc = 2 * pairs;
  Matrix N(3, nc), D(3, 2 * nc);
  contact.b.resize(nc);
  for (Index c = 0; c < nc; ++c) {
    const double angle =
        3.141592653589793 * static_cast<double>(c % pairs) / pairs + (c < pairs ? 0 : 3.141592653589793);
    const double lever = (c < pairs ? 1 : -1) * 0.1 * static_cast<double>(c % pairs);
    N.col(c) << -std::cos(angle), -std::sin(angle), lever;
    D.col(2 * c) << std::sin(angle), -std::cos(angle), 1;
    D.col(2 * c + 1) = -D.col(2 * c);
    contact.b(c) = -0.1 - 0.01 * static_cast<double>(c);
  }
  contact.v = Vector{{0.1, -0.2, 0.3}};
  contact.N = N;
  contact.D = D;
  contact.edges.assign(static_cast<std::size_t>(nc), 2);
  contact.mu = Vector::Constant(nc, 0.4);
  contact.inertia = BlockInertia{{Matrix::Identity(3, 3)}};
  return contact;
}

// No two normals cancel in doubles, although those of a proof with two contacts do but for rounding.
TEST(ContactFarkasTest, NormalsThatOpposeEachOtherButForRoundingContradictEachOther) {
  for (const int pairs : {3, 5, 8}) {
    EXPECT_TRUE(proves_unsolvable(tight_pins(pairs))) << pairs;
    const auto solver = lcpbench_solver_auto().make({});
    solver->load(Problem("pins", tight_pins(pairs)));
    Answer answer;
    solver->solve({.time_limit_s = 60}, answer);
    EXPECT_EQ(answer.claim, Claim::kUnsolvable) << pairs << " " << answer.detail;
  }
}

// The velocities N_i'u = u_i - u_(i+1) of a ring sum to 0 and are asked to be 1 each.
TEST(ContactFarkasTest, ActiveSetDoesNotBlameTheInertiaForAProofThatIsTooLarge) {
  for (const Index n : {64, 65}) {
    ContactProblem ring;
    ring.v = Vector::Zero(n);
    Matrix N = Matrix::Identity(n, n);
    for (Index i = 0; i < n; ++i) N((i + 1) % n, i) = -1;
    ring.N = N;
    ring.D = Matrix(n, 0);
    ring.edges.assign(static_cast<std::size_t>(n), 0);
    ring.mu = Vector::Zero(n);
    ring.b = Vector::Constant(n, -1);
    ring.inertia = DenseInertia{Matrix::Identity(n, n)};
    const auto solver = lcpbench_solver_active_set().make({});
    solver->load(Problem("ring", ring));
    Answer answer;
    solver->solve({}, answer);
    EXPECT_EQ(answer.claim, n <= 64 ? Claim::kUnsolvable : Claim::kNumericalFailure);
    EXPECT_EQ(answer.detail == "no proof", n > 64) << answer.detail;
  }
}

}  // namespace
}  // namespace lcpbench::contact_farkas_test
