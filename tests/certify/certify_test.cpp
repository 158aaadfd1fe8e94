#include <array>
#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/timed_solve.h"
#include "study/certify/certificate.h"
#include "study/certify/integers.h"
#include "tests/certify/certificate_check.h"
#include "tests/support/evaluation_cases.h"

namespace lcpbench::certify_test {
namespace {

using testing::expect_proof;
using testing::Rational;
using testing::rationals;

Certificate certify(const Problem& problem, CertifyOptions options = {}) {
  Certificate certificate = Certifier(options).certify(problem);
  expect_proof(problem, certificate);
  return certificate;
}

Problem bare(std::initializer_list<double> row_major, std::initializer_list<double> q) {
  const auto n = static_cast<Index>(q.size());
  return Problem("bare", Lcp{Matrix(vec(row_major).reshaped(n, n).transpose()), vec(q)});
}

void expect_solution(const Certificate& certificate, const Vector& z) {
  EXPECT_EQ(certificate.kind, CertificateKind::kSolution) << certificate.detail;
  EXPECT_EQ(certificate.proof, ProofKind::kExactBasis);
  EXPECT_EQ(certificate.z, z);
}

// Of an answer that passes although a row, which is 1e-8 of the others, is not solved: see docs/explanation/verdicts.md.
TEST(CertifyTest, SaysWhatASmallRowOfABareLcpHides) {
  const Problem hides = bare({1, 1, 0, 1}, {-1e8, -1});
  EXPECT_TRUE(evaluate(hides, vec({1e8, 0})).solved);
  expect_solution(certify(hides), vec({1e8 - 1, 1}));
  const Problem none = bare({1, 1, 0, 0}, {-1e8, -1});
  EXPECT_TRUE(evaluate(none, vec({1e8, 0})).solved);
  EXPECT_EQ(certify(none).kind, CertificateKind::kUnsolvable);
}

TEST(CertifyTest, OneContactHasItsImpulseAndItsOnlyVelocity) {
  const Problem problem(
      "falling", frictionless(vec({2, -1}), Matrix(vec({0, 1})), DenseInertia{Matrix(vec({3, 4}).asDiagonal())}));
  const Certificate certificate = certify(problem);
  expect_solution(certificate, vec({4}));
  EXPECT_EQ(certificate.velocity, vec({2, 0}));
  EXPECT_EQ(certificate.velocity_unique, true);
  EXPECT_EQ(rationals(certificate.exact_z), (testing::RationalVector{4}));
}

TEST(CertifyTest, AFrictionalContactSlidesAsWorkedOutByHand) {
  const Certificate certificate = certify(sliding_particle());
  expect_solution(certificate, sliding_answer());
  EXPECT_EQ(certificate.velocity, vec({1.5, 0}));
  EXPECT_FALSE(certificate.velocity_unique.has_value());
}

TEST(CertifyTest, WithoutAPositiveMuTheVelocityIsTheOnlyOne) {
  ContactProblem smooth = *sliding_particle().contact();
  smooth.mu.setZero();
  const Problem problem("smooth", smooth);
  const Certificate certificate = certify(problem);
  EXPECT_EQ(certificate.velocity_unique, true);
  testing::expect_proof(problem, certificate);
}

TEST(CertifyTest, AFractionIsExactAndItsDoubleIsTheNearest) {
  const Certificate certificate = certify(bare({3}, {-1}));
  expect_solution(certificate, vec({1.0 / 3}));
  EXPECT_EQ(rationals(certificate.exact_z), (testing::RationalVector{Rational(1, 3)}));
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

TEST(CertifyTest, APlateOnFourFrictionalCornersIsCertifiedFromItsScene) {
  const Problem problem("plate", plate());
  const Certificate certificate = certify(problem);
  EXPECT_EQ(certificate.kind, CertificateKind::kSolution) << certificate.detail;
  ASSERT_EQ(certificate.velocity.size(), 6);
  EXPECT_NEAR(certificate.velocity.cwiseAbs().maxCoeff(), 1.5, 1e-12);
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

TEST(CertifyTest, FactorsThatDependOnEachOtherOrWeighNothingAreNoHindrance) {
  Matrix X(3, 4);
  X << 1, 2, 0, 1, 0, 0, 1, 1, 0, 0, 0, 1;
  const Vector alpha = vec({1, 3, 2, 0});
  Matrix N(3, 3);
  N << 1, 0, 1, 0, 1, 1, 0, 0, 0.5;
  const Certificate solvable =
      certify(Problem("dependent", frictionless(vec({-1, -1, 5}), N, FactoredInertia{X, alpha})));
  EXPECT_EQ(solvable.kind, CertificateKind::kSolution) << solvable.detail;
  EXPECT_EQ(solvable.velocity, vec({0, 0, 5}));
  N << 1, -1, 1, 0, 0, 1, 1, 1, 0.5;
  const Certificate unsolvable =
      certify(Problem("dependent", frictionless(vec({0, 0, -1}), N, FactoredInertia{X, alpha})));
  EXPECT_EQ(unsolvable.kind, CertificateKind::kUnsolvable) << unsolvable.detail;
}

TEST(CertifyTest, AnUnsolvableFrictionalProblemIsContradictedByItsNormals) {
  ContactProblem problem = *squeezed(0.25, -1).contact();
  Matrix D(2, 4);
  D << 0, 0, 1, -1, 1, -1, 0, 0;
  problem.D = D;
  problem.edges = {2, 2};
  problem.mu = vec({0.5, 0.25});
  const Certificate certificate = certify(Problem("gripped", problem));
  EXPECT_EQ(certificate.kind, CertificateKind::kUnsolvable) << certificate.detail;
  EXPECT_EQ(certificate.farkas, vec({1, 1, 0, 0, 0, 0}));
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

// Its linear inequalities have solutions, and none of its cones has one: there is no short proof.
TEST(CertifyTest, AFeasibleProblemWithoutSolutionStaysOpen) {
  EXPECT_EQ(certify(bare({2, 0, 1, 0}, {-2, -2})).kind, CertificateKind::kOpen);
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

/// The processor time that the certifier takes under a time limit. A busy machine takes longer by the clock.
double cpu_s_of_certifying(const Problem& problem, double time_limit_s) {
  Certifier certifier({.time_limit_s = time_limit_s});
  const double begin_s = thread_cpu_clock_s();
  const Certificate certificate = certifier.certify(problem);
  const double cpu_s = thread_cpu_clock_s() - begin_s;
  expect_proof(problem, certificate);
  return cpu_s;
}

TEST(CertifyTest, TheTimeLimitIsObeyed) {
  const Certificate none = certify(sliding_particle(), {.time_limit_s = 0});
  EXPECT_EQ(none.kind, CertificateKind::kOpen);
  EXPECT_EQ(none.detail, "the time limit passed");
  Draw draw(3);
  const Problem hard("hard", Lcp{draw.matrix(60, 60), -draw.vector(60).cwiseAbs() - Vector::Ones(60)});
  EXPECT_LT(cpu_s_of_certifying(hard, 0.05), 2);  // the longest step, with room for sanitizers
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
  const testing::RationalVector other = rationals(certificate.exact_other_potential);
  EXPECT_EQ(other, free_first ? (testing::RationalVector{-1, -3}) : (testing::RationalVector{0, 0}));
  EXPECT_FALSE(certify(Problem("paradox", problem)).velocity_unique.has_value());
}

TEST(CertifyTest, TheSameProblemHasTheSameCertificateWhateverCameBefore) {
  Draw draw(5);
  const Problem problem("frictional", random_frictional(draw, 4, 4, 4));
  const Problem other("other", random_frictional(draw, 5, 3, 4));
  Certifier certifier({});
  const Certificate first = certifier.certify(problem);
  certifier.certify(other);
  const Certificate again = certifier.certify(problem);
  EXPECT_EQ(first.exact_z.numerators, again.exact_z.numerators);
  EXPECT_EQ(first.exact_z.denominator, again.exact_z.denominator);
  EXPECT_EQ(first.detail, again.detail);
}

/// Whether q + M z has a complementary solution, by Gauss and Jordan on every choice of a column for each row,
/// dependent choices included: a row may go without any column, so that independent choices suffice. [Caratheodory]
bool solvable_by_brute_force(const Lcp& lcp) {
  const auto n = static_cast<std::size_t>(lcp.size());
  std::size_t choices = 1;
  for (std::size_t i = 0; i < n; ++i) choices *= 3;
  for (std::size_t choice = 0; choice < choices; ++choice) {
    std::vector<testing::RationalVector> columns;  // of w - M z = q, then q
    for (std::size_t i = 0, digits = choice; i < n; ++i, digits /= 3) {
      if (digits % 3 == 2) continue;
      testing::RationalVector column(n);
      for (std::size_t r = 0; r < n; ++r) {
        const double entry = lcp.M(static_cast<Index>(r), static_cast<Index>(i));
        column[r] = digits % 3 == 1 ? Rational(-entry) : Rational(r == i ? 1 : 0);
      }
      columns.push_back(std::move(column));
    }
    columns.push_back(rationals(lcp.q));
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

// Random problems of few unknowns, most of them neither monotone nor copositive. Those that have a solution are all
// solved; of those that have none, the ones whose linear inequalities contradict each other are contradicted.
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
    ASSERT_EQ(certificate.kind == CertificateKind::kSolution, truth) << trial << ": " << certificate.detail;
    (truth ? solvable : unsolvable) += certificate.kind == CertificateKind::kOpen ? 0 : 1;
  }
  EXPECT_GT(solvable, 100);
  EXPECT_GT(unsolvable, 50);
}

// Two equal columns and entries that are zero to rounding: the support of a float answer is no basis.
TEST(CertifyTest, RowsThatAFloatAnswerLeavesUnclearAreSettledExactly) {
  const double tiny = 0x1p-60;
  Matrix M(3, 3);
  M << 2, 2, 0, 2, 2 + tiny, 1, 0, 1, tiny;
  const Problem problem("unclear", Lcp{M, vec({-2, -2, -tiny})});
  EXPECT_EQ(certify(problem).kind == CertificateKind::kSolution, solvable_by_brute_force(problem.lcp()));
}

// Cholesky's method in double proves neither: that of the first is within its rounding, and in the second it meets
// infinity times zero, and NaN is no pivot below zero.
TEST(CertifyTest, InertiaThatDoublesCannotJudgeIsJudgedExactly) {
  const auto detail = [](const Matrix& G) {
    return certify(Problem("inertia", frictionless(vec({0, 0, -1}), Matrix(vec({0, 0, 1})), DenseInertia{G}))).detail;
  };
  Matrix G = Matrix::Identity(3, 3);
  G(0, 1) = G(1, 0) = 1 - 0x1p-53;
  EXPECT_EQ(detail(G), "basis of active_set");
  G(0, 1) = G(1, 0) = 1;
  EXPECT_NE(detail(G).find("not symmetric positive definite"), std::string::npos);
  G = 1e-139 * Matrix::Identity(3, 3);
  G(0, 2) = G(2, 0) = 1e300;
  EXPECT_NE(detail(G).find("not symmetric positive definite"), std::string::npos);
}

// Exact arithmetic on entries of 2000 bits: one step takes longer than the limit.
TEST(CertifyTest, TheTimeLimitHoldsWithinAStep) {
  Draw draw(9);
  Matrix M = draw.matrix(90, 90);
  for (double& entry : M.reshaped()) entry *= std::exp2(std::round(900 * draw.vector(1)(0)));
  EXPECT_LT(cpu_s_of_certifying(Problem("wide", Lcp{M, draw.vector(90)}), 0.2), 2);  // with room for sanitizers
  ContactProblem contact = random_frictional(draw, 60, 60, 4);
  EXPECT_LT(cpu_s_of_certifying(Problem("large", contact), 0.2), 2);
}

// The second row of A is twice the first, and the second column three times the first: of 2 x_1 + x_3 = 1 and
// 5 x_1 + 7 x_3 = 8 the solution is (-1/9, 11/9).
TEST(DeterminedTest, TheFirstIndependentEquationsAreSolvedExactly) {
  exact::IntegerMatrix A(3, 3);
  exact::IntegerMatrix b(3);
  const slong given[] = {2, 6, 1, 4, 12, 2, 5, 15, 7};
  for (Index i = 0; i < 9; ++i) fmpz_set_si(A(i / 3, i % 3), given[i]);
  for (Index i = 0; i < 3; ++i) fmpz_set_si(b(i), std::array<slong, 3>{1, 5, 8}[static_cast<std::size_t>(i)]);
  exact::Integer denominator;
  const exact::IntegerMatrix x = exact::determined(A, b, denominator, exact::Deadline(60));
  const auto entry = [&](Index i) { return exact::rounded(x(i), denominator); };
  EXPECT_EQ(entry(0), -1.0 / 9);
  EXPECT_EQ(entry(1), 0);
  EXPECT_EQ(entry(2), 11.0 / 9);
  EXPECT_THROW(exact::determined(A, b, denominator, exact::Deadline(0)), exact::TimePassed);
}

double quotient(slong a, slong shift, slong b) {
  exact::Integer left(a);
  exact::Integer right(b);
  exact::Integer& scaled = shift > 0 ? left : right;
  fmpz_mul_2exp(scaled.get(), scaled.get(), static_cast<ulong>(std::abs(shift)));
  return exact::rounded(left.get(), right);
}

TEST(RoundingTest, QuotientsRoundAsTheProcessorDividesThem) {
  Draw draw(29);
  for (int trial = 0; trial < 20000; ++trial) {
    const auto mantissa = [&] { return static_cast<slong>(draw.bits() >> 11) + 1; };
    const slong a = mantissa();
    const slong b = mantissa();
    const int shift = static_cast<int>(draw.bits() % 2200) - 1100;
    // a 2^shift / b: scaled in two exact steps where b is a power of two only, so both operands stay normal
    const double left = std::ldexp(static_cast<double>(a), std::max(shift, -1000));
    const double right = std::ldexp(static_cast<double>(b), std::max(0, -1000 - shift));
    if (!std::isfinite(left)) continue;
    EXPECT_EQ(quotient(a, shift, b), left / right) << a << " " << shift << " " << b;
  }
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
