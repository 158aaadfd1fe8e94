#include <array>
#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <boost/multiprecision/cpp_int.hpp>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/timed_solve.h"
#include "study/certify/certificate.h"
#include "study/certify/integers.h"
#include "tests/certify/checked_proofs.h"
#include "tests/support/evaluation_cases.h"

namespace lcpbench::certify_test {
namespace {

using testing::expect_proof;
using Rational = boost::multiprecision::cpp_rational;
using RationalVector = std::vector<Rational>;

Certificate certify(const Problem& problem, CertifyOptions options = {}) {
  Certificate certificate = Certifier(options).certify(problem);
  expect_proof(problem, certificate);
  return certificate;
}

using Fractions = std::vector<std::string>;

Problem bare(std::initializer_list<double> row_major, std::initializer_list<double> q) {
  const auto n = static_cast<Index>(q.size());
  return Problem("bare", Lcp{Matrix(vec(row_major).reshaped(n, n).transpose()), vec(q)});
}

void expect_solution(const Certificate& certificate, const Vector& z) {
  EXPECT_EQ(certificate.kind, CertificateKind::kSolution) << certificate.detail;
  EXPECT_EQ(certificate.proof, ProofKind::kExactBasis);
  EXPECT_EQ(certificate.z, z);
}

// Of an answer that passes although a row, whose q is 1e-10 of the others', is not solved: the floor F_i of its error is
// that of its block. See docs/explanation/verdicts.md.
TEST(CertifyTest, SaysWhatASmallRowOfABareLcpHides) {
  const Problem hides = bare({1, 1, 0, 1}, {-1e10, -1});
  EXPECT_TRUE(evaluate(hides, vec({1e10, 0})).solved);
  expect_solution(certify(hides), vec({1e10 - 1, 1}));
  const Problem none = bare({1, 1, 0, 0}, {-1e10, -1});
  EXPECT_TRUE(evaluate(none, vec({1e10, 0})).solved);
  EXPECT_EQ(certify(none).kind, CertificateKind::kUnsolvable);
}

TEST(CertifyTest, OneContactHasItsImpulseAndItsOnlyVelocity) {
  const Problem problem(
      "falling", frictionless(vec({2, -1}), Matrix(vec({0, 1})), DenseInertia{Matrix(vec({3, 4}).asDiagonal())}));
  const Certificate certificate = certify(problem);
  expect_solution(certificate, vec({4}));
  EXPECT_EQ(certificate.velocity, vec({2, 0}));
  EXPECT_EQ(certificate.velocity_unique, true);
  EXPECT_EQ(fractions(certificate.exact_z), Fractions{"4"});
}

TEST(CertifyTest, AFrictionalContactSlidesAsWorkedOutByHand) {
  const Certificate certificate = certify(sliding_particle());
  expect_solution(certificate, sliding_answer());
  EXPECT_EQ(certificate.velocity, vec({1.5, 0}));
  EXPECT_FALSE(certificate.velocity_unique.has_value());
}

TEST(CertifyTest, AFractionIsExactAndItsDoubleIsTheNearest) {
  const Certificate certificate = certify(bare({3}, {-1}));
  expect_solution(certificate, vec({1.0 / 3}));
  EXPECT_EQ(fractions(certificate.exact_z), Fractions{"1/3"});
}

// Four corners of a box: one of their normals depends on the others, so that the impulses are not determined.
TEST(CertifyTest, RedundantCornersOfABoxHaveOneVelocity) {
  Matrix N(3, 4);  // vertical velocity and two rotations
  N << 1, 1, 1, 1, -1, 1, -1, 1, -1, -1, 1, 1;
  const Vector v = vec({-1, 0, 0});
  const Matrix G = Matrix(vec({2, 3, 5}).asDiagonal());
  Matrix X(3, 3);
  X << 1, 1, 0, 0, 1, 1, 0, 0, 1;
  for (const Inertia& inertia :
       {Inertia(DenseInertia{G}), Inertia(BlockInertia{{G.topLeftCorner(1, 1), G.bottomRightCorner(2, 2)}}),
        Inertia(FactoredInertia{X, vec({1, 2, 3})}), Inertia(InverseInertia{G})}) {
    const Certificate certificate = certify(Problem("box", frictionless(v, N, inertia)));
    EXPECT_EQ(certificate.kind, CertificateKind::kSolution) << certificate.detail;
    EXPECT_EQ(certificate.velocity, vec({0, 0, 0}));
    EXPECT_EQ(certificate.velocity_unique, true);
  }
}

// Two contacts push along x against each other and up together; nothing has inertia along y.
Problem squeezed(double vx, double vy, double right = -1) {
  Matrix N(2, 2);
  N << 1, right, 1, 1;
  return Problem("squeezed", frictionless(vec({vx, vy}), N, FactoredInertia{Matrix(vec({1, 0})), vec({2})}));
}

TEST(CertifyTest, AReducedRankProblemIsSolvedOrContradicted) {
  const Certificate unsolvable = certify(squeezed(0.25, -1));
  EXPECT_EQ(unsolvable.kind, CertificateKind::kUnsolvable) << unsolvable.detail;
  EXPECT_EQ(unsolvable.proof, ProofKind::kFarkas);
  EXPECT_EQ(unsolvable.farkas, vec({1, 1}));
  const Certificate uneven = certify(squeezed(0.25, -1, -0.3));
  EXPECT_EQ(uneven.kind, CertificateKind::kUnsolvable) << uneven.detail;
  EXPECT_EQ(uneven.farkas, vec({0.3, 1}));
  const Certificate barely = certify(squeezed(0, -0x1p-1000));
  EXPECT_EQ(barely.kind, CertificateKind::kUnsolvable) << barely.detail;
  const Certificate solvable = certify(squeezed(0.25, 0));
  EXPECT_EQ(solvable.kind, CertificateKind::kSolution) << solvable.detail;
  EXPECT_EQ(solvable.velocity_unique, true);
}

TEST(CertifyTest, InertiaThatIsNoInertiaProvesNothing) {
  Matrix G(2, 2);
  G << 1, 2, 2, 1;
  EXPECT_EQ(certify(Problem("indefinite", frictionless(vec({0, -1}), Matrix(vec({0, 1})), DenseInertia{G}))).kind,
            CertificateKind::kOpen);
  EXPECT_EQ(certify(Problem("negative", frictionless(vec({0, -1}), Matrix(vec({0, 1})),
                                                     FactoredInertia{Matrix::Identity(2, 2), vec({1, -1})})))
                .kind,
            CertificateKind::kOpen);
}

TEST(CertifyTest, SolutionsBeyondLemkesRaysAreFound) {
  expect_solution(certify(bare({0, 1, 1, 0}, {-2, -2})), vec({2, 2}));
}

/// A body between two walls that converge downwards and close in on it at 1 m/s, below the angle of friction: to part
/// from both it has to rise, and friction holds it down. No frictionless contacts contradict each other.
ContactProblem tapered_jam(double mu) {
  ContactProblem jam = testing::frictionless(vec({0, 0}), Matrix{{1, -1}, {0.5, 0.5}}, DenseInertia{Matrix::Identity(2, 2)});
  jam.b = vec({-1, -1});
  jam.D = Matrix{{-0.5, 0.5, 0.5, -0.5}, {1, -1, 1, -1}};
  jam.edges = {2, 2};
  jam.mu = vec({mu, mu});
  return jam;
}

// Their linear inequalities have solutions, and none of their cones has one: only that every basis fails is a proof.
TEST(CertifyTest, FeasibleProblemsWithoutASolutionAreDecidedByEveryBasis) {
  for (const Problem& problem : {bare({2, 0, 1, 0}, {-2, -2}), Problem("jam", tapered_jam(1))}) {
    const Certificate certificate = certify(problem);
    EXPECT_EQ(certificate.kind, CertificateKind::kUnsolvable) << certificate.detail;
    EXPECT_EQ(certificate.proof, ProofKind::kEveryBasis);
  }
  EXPECT_EQ(certify(Problem("above the angle", tapered_jam(0.25))).kind, CertificateKind::kSolution);
}

TEST(CertifyTest, AnInfeasibleProblemIsContradicted) {
  const Certificate monotone = certify(bare({1, -1, -1, 1}, {-1, -1}));
  EXPECT_EQ(monotone.proof, ProofKind::kFarkas) << monotone.detail;
  EXPECT_EQ(monotone.farkas, vec({1, 1}));
  const Certificate negative = certify(bare({-1, 0, 0, 1}, {-1, -1}));  // w_1 = -1 - z_1, and M is not semidefinite
  EXPECT_EQ(negative.proof, ProofKind::kFarkas) << negative.detail;
}

TEST(CertifyTest, EmptyProblemsAreSolved) {
  EXPECT_EQ(certify(Problem("nothing", Lcp{Matrix(0, 0), Vector(0)})).kind, CertificateKind::kSolution);
  const Certificate free =
      certify(Problem("free", frictionless(vec({1, 2}), Matrix(2, 0), DenseInertia{Matrix::Identity(2, 2)})));
  EXPECT_EQ(free.kind, CertificateKind::kSolution) << free.detail;
  EXPECT_EQ(free.velocity, vec({1, 2}));
}

TEST(CertifyTest, TinyAndHugeDataAreExact) {
  const auto scaled = [](double inertia, double velocity) {
    Matrix N(2, 2);
    N << 1, 0.5, 0, 1;
    return Problem("scaled", frictionless(velocity * vec({-1, -1}), N, DenseInertia{inertia * Matrix::Identity(2, 2)}));
  };
  const Vector z = certify(scaled(1, 1)).z;
  EXPECT_EQ(certify(scaled(0x1p1000, 0x1p-1000)).z, z);
  EXPECT_EQ(certify(scaled(0x1p-1000, 0x1p1000)).z, z);
  for (const double inertia : {1e-300, 1e300}) {
    for (const double velocity : {1e-300, 1e-5, 1e300}) {
      EXPECT_EQ(certify(scaled(inertia, velocity)).kind, CertificateKind::kSolution) << inertia << " " << velocity;
    }
  }
  expect_solution(certify(bare({1e-300, 0, 0, 1e300}, {-1e-300, -1e300})), vec({1, 1}));
}

TEST(CertifyTest, DataThatAreNoNumbersAreRefused) {
  EXPECT_THROW(certify(bare({kNan}, {1})), InputError);
  EXPECT_THROW(certify(bare({1}, {kInf})), InputError);
  EXPECT_THROW(certify(Problem("nan", frictionless(vec({kNan}), Matrix::Ones(1, 1), DenseInertia{Matrix::Ones(1, 1)}))),
               InputError);
}

TEST(CertifyTest, TheTimeLimitIsObeyed) {
  const Certificate none = certify(sliding_particle(), {.time_limit_s = 0});
  EXPECT_EQ(none.kind, CertificateKind::kOpen);
  EXPECT_EQ(none.detail, "the time limit passed");
  Draw draw(9);
  Matrix M = draw.matrix(90, 90);  // of 2000 bits: one step takes longer than the limit
  for (double& entry : M.reshaped()) entry *= std::exp2(std::round(900 * draw.vector(1)(0)));
  const double begin_s = thread_cpu_clock_s();  // a busy machine takes longer by the clock
  certify(Problem("wide", Lcp{M, draw.vector(90)}), {.time_limit_s = 0.2});
  EXPECT_LT(thread_cpu_clock_s() - begin_s, 2);  // with room for sanitizers
}

// Painleve's paradox: mu couples so much that a pressed contact draws itself in. Free flight at (5, 1) and sliding at
// (2, 0) under f_n = 1, f_t = -2 are both solutions: M_dense = [1 1; 1 2], q = (1, 5), mu = 2.
TEST(CertifyTest, TwoVelocitiesOfPainlevesParadoxAreBothCertified) {
  ContactProblem problem;
  problem.v = vec({1, 5});
  problem.N = Matrix(vec({1, 0}));
  Matrix D(2, 2);
  D << 0, 0, 1, -1;
  problem.D = D;
  problem.edges = {2};
  problem.mu = vec({2});
  Matrix G(2, 2);
  G << 2, -1, -1, 1;  // the inverse of [1 1; 1 2]
  problem.inertia = DenseInertia{G};
  const Certificate certificate = certify(Problem("paradox", problem), {.seek_other_velocity = true});
  EXPECT_EQ(certificate.kind, CertificateKind::kSolution);
  EXPECT_EQ(certificate.velocity_unique, false);
  const bool free_first = certificate.velocity(0) == 1;
  EXPECT_EQ(certificate.velocity, free_first ? vec({1, 5}) : vec({0, 2}));
  EXPECT_EQ(fractions(certificate.exact_other_potential), free_first ? (Fractions{"-1", "-3"}) : (Fractions{"0", "0"}));
  EXPECT_FALSE(certify(Problem("paradox", problem)).velocity_unique.has_value());
}

/// Whether q + M z has a complementary solution, by Gauss and Jordan on every choice of a column for each row,
/// dependent choices included: a row may go without any column, so that independent choices suffice. [Caratheodory]
bool solvable_by_brute_force(const Lcp& lcp) {
  const auto n = static_cast<std::size_t>(lcp.size());
  std::size_t choices = 1;
  for (std::size_t i = 0; i < n; ++i) choices *= 3;
  for (std::size_t choice = 0; choice < choices; ++choice) {
    std::vector<RationalVector> columns;  // of w - M z = q, then q
    for (std::size_t i = 0, digits = choice; i < n; ++i, digits /= 3) {
      if (digits % 3 == 2) continue;
      RationalVector column(n);
      for (std::size_t r = 0; r < n; ++r) {
        const double entry = lcp.M(static_cast<Index>(r), static_cast<Index>(i));
        column[r] = digits % 3 == 1 ? Rational(-entry) : Rational(r == i ? 1 : 0);
      }
      columns.push_back(std::move(column));
    }
    columns.emplace_back(lcp.q.begin(), lcp.q.end());
    std::size_t rank = 0;
    bool independent = true;
    for (std::size_t c = 0; c + 1 < columns.size() && independent; ++c) {
      std::size_t pivot = rank;
      while (pivot < n && columns[c][pivot].is_zero()) ++pivot;
      independent = pivot < n;
      if (!independent) break;
      for (auto& column : columns) std::swap(column[pivot], column[rank]);
      for (std::size_t r = 0; r < n; ++r) {
        if (r == rank || columns[c][r].is_zero()) continue;
        const Rational ratio = columns[c][r] / columns[c][rank];
        for (std::size_t d = c; d < columns.size(); ++d) columns[d][r] -= ratio * columns[d][rank];
      }
      ++rank;
    }
    bool solves = independent;
    for (std::size_t r = 0; r < n && solves; ++r) {
      const Rational& right = columns.back()[r];
      solves = r < rank ? right.is_zero() || (right > 0) == (columns[r][r] > 0) : right.is_zero();
    }
    if (solves) return true;
  }
  return false;
}

/// Entries that tie, differ by an ulp or in the 10th digit, or lie hundreds of orders of magnitude apart.
double nasty_entry(Draw& draw, int style) {
  const double base = std::round(3 * draw.vector(1)(0));
  switch (style) {
    case 0: return base;
    case 1: return std::nextafter(base, draw.vector(1)(0) > 0 ? 10.0 : -10.0);
    case 2: return base * (1 + 1e-10 * std::round(draw.vector(1)(0)));
    case 3: return base * std::exp2(std::round(900 * draw.vector(1)(0)));
    default: return base == 0 ? std::numeric_limits<double>::denorm_min() : base;
  }
}

// Random problems of few unknowns, most of them neither monotone nor copositive: all are decided.
TEST(CertifyTest, NastySmallProblemsAreDecidedAsByBruteForce) {
  Draw draw(20260721);
  int solvable = 0;
  int unsolvable = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Index n = 1 + trial % 4;
    Lcp lcp{Matrix(n, n), Vector(n)};
    for (double& entry : lcp.M.reshaped()) entry = nasty_entry(draw, trial % 5);
    for (double& entry : lcp.q) entry = nasty_entry(draw, trial % 5);
    if (trial % 3 == 0 && n > 1) lcp.M.row(0) = 2 * lcp.M.row(n - 1);
    if (trial % 7 == 0) lcp.M = Matrix(lcp.M - lcp.M.transpose());
    const Certificate certificate = certify(Problem("nasty", lcp));
    const bool truth = solvable_by_brute_force(lcp);
    ASSERT_EQ(certificate.kind, truth ? CertificateKind::kSolution : CertificateKind::kUnsolvable)
        << trial << ": " << certificate.detail;
    ++(truth ? solvable : unsolvable);
  }
  EXPECT_GT(solvable, 100);
  EXPECT_GT(unsolvable, 50);
}

// Cholesky's method in double proves neither: that of the first is within its rounding, and in the second it meets
// infinity times zero, and NaN is no pivot below zero.
TEST(CertifyTest, InertiaThatDoublesCannotJudgeIsJudgedExactly) {
  const auto detail = [](const Matrix& G) {
    return certify(Problem("inertia", frictionless(vec({0, 0, -1}), Matrix(vec({0, 0, 1})), DenseInertia{G}))).detail;
  };
  Matrix G = Matrix::Identity(3, 3);
  G(0, 1) = G(1, 0) = 1 - 0x1p-53;
  EXPECT_EQ(detail(G), "basis of contact_lemke{precision=quad}");
  G(0, 1) = G(1, 0) = 1;
  EXPECT_NE(detail(G).find("not symmetric positive definite"), std::string::npos);
  G = 1e-139 * Matrix::Identity(3, 3);
  G(0, 2) = G(2, 0) = 1e300;
  EXPECT_NE(detail(G).find("not symmetric positive definite"), std::string::npos);
}

// Two opposed contacts leave each other a gap that is an ulp too small, beside one with friction.
TEST(CertifyTest, NormalsThatContradictEachOtherByAnUlpAreContradicted) {
  Matrix N = Matrix::Zero(3, 3);
  N.row(0) << 1, -1, 0;
  N(1, 2) = 1;
  ContactProblem contact = frictionless(vec({0, -1, 1}), N, DenseInertia{Matrix::Identity(3, 3)});
  contact.b = vec({-1, 1 - 0x1p-52, 0});
  Matrix D = Matrix::Zero(3, 2);
  D.row(2) << 1, -1;
  contact.D = D;
  contact.edges = {0, 0, 2};
  contact.mu = vec({0, 0, 0.5});
  const Certificate certificate = certify(Problem("an ulp", std::move(contact)));
  EXPECT_EQ(certificate.proof, ProofKind::kFarkas) << certificate.detail;
}

double quotient(slong a, slong shift, slong b) {
  exact::Integer left(a);
  exact::Integer right(b);
  exact::Integer& scaled = shift > 0 ? left : right;
  fmpz_mul_2exp(scaled.get(), scaled.get(), static_cast<ulong>(std::abs(shift)));
  return exact::rounded(left.get(), right);
}

TEST(RoundingTest, TiesGoToEvenAndTheEndsOfTheRangeAreKept) {
  const slong big = slong{1} << 53;
  EXPECT_EQ(quotient(big + 1, 0, 1), static_cast<double>(big));
  EXPECT_EQ(quotient(-big - 3, 0, 1), -static_cast<double>(big + 4));
  EXPECT_EQ(quotient(1, -1074, 1), 0x1p-1074);
  EXPECT_EQ(quotient(1, -1075, 1), 0);
  EXPECT_EQ(quotient(3, -1076, 1), 0x1p-1074);
  EXPECT_EQ(quotient(1, -100000, 1), 0);
  EXPECT_EQ(quotient(big - 1, 971, 1), std::numeric_limits<double>::max());
  EXPECT_EQ(quotient(2 * big - 1, 970, 1), kInf);
  EXPECT_EQ(quotient(-1, 100000, 1), -kInf);
  EXPECT_EQ(quotient(0, 100000, 1), 0);
}

}  // namespace
}  // namespace lcpbench::certify_test
