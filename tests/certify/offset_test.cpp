// The offset b of the normal rows, 0 <= f_N perpendicular to N'v+ + b >= 0, through solvers, verdicts and certificates.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "generators/sets.h"
#include "study/certify/certificate.h"
#include "tests/certify/checked_proofs.h"
#include "tests/certify/natives.h"
#include "tests/support/evaluation_cases.h"

namespace lcpbench::offset_test {
namespace {

using testing::native_names;
using testing::solve;

// Methods that end in a vertex, or at one, on these problems.
const std::vector<std::string> kDirect{"auto",
                                       "contact_lemke",
                                       "contact_lemke{precision=double}",
                                       "lemke",
                                       "contact_lemke{precision=quad}",
                                       "active_set",
                                       "velocity_ipm",
                                       "friction_ipm"};

/// A particle of mass 2 above the ground y = 0. @param inertia  of two coordinates
Problem falling(double speed, double offset, Inertia inertia = DenseInertia{2 * Matrix::Identity(2, 2)}) {
  ContactProblem contact = frictionless(vec({0.5, -speed}), Matrix(vec({0, 1})), std::move(inertia));
  contact.b = vec({offset});
  return Problem("falling", contact);
}

/// A box between two walls that want it to move apart from both by `gap` [m/s].
ContactProblem squeezed(double gap) {
  Matrix N(2, 2);
  N << 1, -1, 0, 0;
  ContactProblem contact = frictionless(vec({0, 0}), N, BlockInertia{{Matrix::Identity(2, 2)}});
  contact.b = vec({-gap, -gap});
  return contact;
}

Certificate certify(const Problem& problem) {
  Certificate certificate = Certifier({.time_limit_s = 20}).certify(problem);
  testing::expect_proof(problem, certificate);
  return certificate;
}

TEST(OffsetTest, AGapClosesExactlyAndAnImpactBouncesBack) {
  for (const std::string& solver : native_names()) {
    if (find_solver(solver).definition.capabilities.needs == Needs::kScene) continue;
    SCOPED_TRACE(solver);
    const auto speed_after = [&](const Problem& problem) {
      const Answer answer = solve(solver, problem);
      EXPECT_EQ(answer.claim, Claim::kSolved) << answer.detail;
      EXPECT_TRUE(Evaluator(problem).errors(answer).solved);
      return answer.z.size() == 1 ? post_impact_velocity(*problem.contact(), answer.z)(1) : kNan;
    };
    EXPECT_NEAR(speed_after(falling(3, 2)), -2, 1e-5);        // a gap of 2 h
    EXPECT_NEAR(speed_after(falling(3, 4)), -3, 1e-5);        // one that it does not reach
    EXPECT_NEAR(speed_after(falling(4, -2)), 2, 1e-5);        // restitution of 1/2
    EXPECT_NEAR(speed_after(falling(0, -0.25)), 0.25, 1e-5);  // out of a penetration, from rest
    EXPECT_NEAR(speed_after(falling(3, 2, InverseInertia{Matrix::Identity(2, 2)})), -2, 1e-5);
    EXPECT_NEAR(speed_after(falling(3, 2, FactoredInertia{Matrix::Identity(2, 2), vec({1, 2})})), -2, 1e-5);
  }
}

TEST(OffsetTest, AnotherVelocityKeepsOffsetAndCompliance) {
  for (const std::string& solver : native_names()) {
    SCOPED_TRACE(solver);
    ContactProblem contact = *falling(3, 2).contact();
    for (const double compliance : {0.0, 0.5}) {
      contact.compliance_n = vec({compliance});
      const std::unique_ptr<Solver> object = make_solver(parse_spec(solver));
      object->load(Problem("falling", contact));
      object->update(vec({0.5, -7}));
      Answer answer;
      object->solve({}, answer);
      EXPECT_EQ(answer.claim, Claim::kSolved) << answer.detail;
      ASSERT_EQ(answer.z.size(), 1);
      EXPECT_NEAR(answer.z(0), 5 / (0.5 + compliance), 1e-4);
      EXPECT_THROW(object->update(vec({0.5, -3, 0})), std::invalid_argument);
    }
  }
}

struct Tally {
  int problems = 0;
  int solvable = 0;
  int unsolvable = 0;
};

/// The same with one contact more, which pushes against the first: offsets may ask both for more than they can have.
ContactProblem opposed(const ContactProblem& contact) {
  ContactProblem more = contact;
  Matrix N(contact.ngc(), contact.nc() + 1);
  N << to_dense(contact.N), -to_dense(contact.N).col(0);
  more.N = N;
  more.edges.push_back(0);
  more.mu.conservativeResize(contact.nc() + 1);
  more.mu(contact.nc()) = 0;
  return more;
}

/// Problems of a set with offsets of the size of their speeds; every native solver is measured by the certificate.
Tally compare_with_certificates(const std::string& set, std::int64_t trials, std::uint64_t seed) {
  Tally tally;
  Draw draw(seed);
  for (std::int64_t trial = 0; trial < trials; ++trial) {
    ContactProblem contact = *open_set(set)->generate(5, trial).contact();
    if (contact.nc() == 0) continue;
    if (trial % 2 == 1) contact = opposed(contact);
    const double scale = std::max(1e-3, form_lcp(contact).q.head(contact.nc()).lpNorm<Eigen::Infinity>());
    contact.b = scale * draw.vector(contact.nc());
    const Problem problem(set + " " + std::to_string(trial), contact);
    const Certificate certificate = certify(problem);
    Evaluator evaluator(problem);
    ++tally.problems;
    if (certificate.kind == CertificateKind::kSolution) ++tally.solvable;
    if (certificate.kind == CertificateKind::kUnsolvable) ++tally.unsolvable;
    const Truth truth = certificate.kind == CertificateKind::kUnsolvable ? Truth::kUnsolvable
                        : certificate.kind == CertificateKind::kSolution ? Truth::kSolvable
                                                                         : Truth::kUnknown;
    EXPECT_FALSE(evaluator.truth() == Truth::kSolvable && truth == Truth::kUnsolvable);
    for (const std::string& solver : native_names()) {
      SCOPED_TRACE(solver + " on " + problem.name());
      const Answer answer = solve(solver, problem);
      const Errors errors = evaluator.errors(answer);
      if (answer.claim == Claim::kSolved) {
        EXPECT_EQ(verdict(answer.claim, errors, truth), Verdict::kSolved) << errors.velocity_residual_relative;
      }
      if (answer.claim == Claim::kUnsolvable) {
        EXPECT_NE(truth, Truth::kSolvable) << answer.detail;
      }
      const bool exact =
          solver == "auto" || solver == "contact_lemke" || (solver == "active_set" && !contact.frictional());
      if (exact && truth == Truth::kSolvable) {
        EXPECT_EQ(answer.claim, Claim::kSolved) << answer.detail;
      }
      // Where double does not decide, active_set claims nothing.
      if (exact && solver != "active_set" && truth == Truth::kUnsolvable) {
        EXPECT_EQ(answer.claim, Claim::kUnsolvable) << answer.detail;
      }
      if (exact && answer.claim == Claim::kSolved && certificate.velocity_unique == true) {
        const Vector velocity = post_impact_velocity(contact, answer.z);
        EXPECT_LE((velocity - certificate.velocity).norm(), 1e-6 * (certificate.velocity.norm() + scale));
      }
    }
  }
  return tally;
}

TEST(OffsetTest, NativesAgreeWithTheCertificatesOfRandomFrictionlessProblems) {
  const Tally scenes = compare_with_certificates("rigid/exp1{nc_max=8}", 12, 1);
  EXPECT_EQ(scenes.solvable + scenes.unsolvable, scenes.problems);
  EXPECT_GT(scenes.solvable, 0);
  EXPECT_GT(scenes.unsolvable, 0);
  const Tally definite = compare_with_certificates("planted/definite", 8, 2);
  EXPECT_EQ(definite.solvable + definite.unsolvable, definite.problems);
  const Tally singular = compare_with_certificates("paper/monotone/exp3{nc_max=8}", 8, 3);
  EXPECT_EQ(singular.solvable + singular.unsolvable, singular.problems);
}

TEST(OffsetTest, NativesAgreeWithTheCertificatesOfRandomProblemsWithFriction) {
  const Tally scenes = compare_with_certificates("rigid/frictional/exp1{bodies_max=2,nc_max=4}", 10, 4);
  EXPECT_GT(scenes.solvable, 0);
  EXPECT_GT(scenes.unsolvable, 0);
}

void expect_proven_unsolvable(const Problem& problem) {
  SCOPED_TRACE(problem.name());
  const Certificate certificate = certify(problem);
  EXPECT_EQ(certificate.kind, CertificateKind::kUnsolvable) << certificate.detail;
  EXPECT_EQ(certificate.proof, ProofKind::kFarkas);
  Evaluator evaluator(problem);
  EXPECT_EQ(evaluator.truth(), Truth::kUnknown);
  for (const std::string& solver : native_names()) {
    SCOPED_TRACE(solver);
    const Answer answer = solve(solver, problem);
    EXPECT_NE(answer.claim, Claim::kSolved);
    const bool proves =
        solver == "auto" || solver == "contact_lemke" || (solver == "active_set" && !problem.contact()->frictional());
    if (!proves) continue;
    EXPECT_EQ(answer.claim, Claim::kUnsolvable) << answer.detail;
    EXPECT_TRUE(evaluator.check_farkas(answer.farkas)) << answer.farkas.transpose();
  }
}

TEST(OffsetTest, TwoWallsThatCloseInOnABoxHaveNoSolution) {
  for (const Inertia& inertia :
       {Inertia(BlockInertia{{Matrix::Identity(2, 2)}}), Inertia(DenseInertia{Matrix{{2.0, 1.0}, {1.0, 3.0}}}),
        Inertia(InverseInertia{Matrix::Identity(2, 2)}),
        Inertia(FactoredInertia{Matrix::Identity(2, 2), vec({1, 2})})}) {
    ContactProblem contact = squeezed(1);
    contact.inertia = inertia;
    expect_proven_unsolvable(Problem("walls", contact));
    contact.v = vec({5, -1});
    expect_proven_unsolvable(Problem("moving between walls", contact));
    contact.b = vec({-1, 0.5});  // of one wall, by less
    expect_proven_unsolvable(Problem("one wall", contact));
  }
  ContactProblem just = squeezed(0);  // without the gap it may stay
  just.b = vec({-0.5, 0.5});
  EXPECT_EQ(certify(Problem("just", just)).kind, CertificateKind::kSolution);
  for (const char* solver : {"auto", "contact_lemke", "active_set"}) {
    const Answer answer = solve(solver, Problem("just", just));
    EXPECT_EQ(answer.claim, Claim::kSolved) << solver << ": " << answer.detail;
  }
}

TEST(OffsetTest, OneIslandWithoutASolutionIsEnough) {
  Matrix N = Matrix::Zero(4, 3);  // one body falls, the other is between walls
  N(1, 0) = N(2, 1) = 1;
  N(2, 2) = -1;
  ContactProblem contact =
      frictionless(vec({1, -3, 0, 0}), N, BlockInertia{{Matrix::Identity(2, 2), Matrix::Identity(2, 2)}});
  contact.b = vec({1, -0.5, 0.25});
  expect_proven_unsolvable(Problem("islands", contact));
  contact.b = vec({1, -0.5, 0.75});
  const Problem solvable("islands", contact);
  EXPECT_EQ(certify(solvable).kind, CertificateKind::kSolution);
  for (const std::string& solver : native_names()) {
    SCOPED_TRACE(solver);
    const Answer answer = solve(solver, solvable);
    EXPECT_EQ(answer.claim, Claim::kSolved) << answer.detail;
    EXPECT_TRUE(Evaluator(solvable).errors(answer).solved);
  }
}

TEST(OffsetTest, AContactThatNothingMovesNeedsAnOffsetOfZeroOrMore) {
  Matrix N = Matrix::Zero(2, 2);
  N(0, 0) = 1;
  ContactProblem contact = frictionless(vec({-1, 0}), N, BlockInertia{{Matrix::Ones(1, 1), Matrix::Ones(1, 1)}});
  contact.b = vec({0, -1e-9});
  expect_proven_unsolvable(Problem("immovable", contact));
  contact.b = vec({0, 1e-9});
  for (const char* solver : {"auto", "contact_lemke", "active_set"}) {
    EXPECT_EQ(solve(solver, Problem("immovable", contact)).claim, Claim::kSolved) << solver;
  }
}

TEST(OffsetTest, VerdictsMeasureTheRowWithItsOffset) {
  const Problem problem = falling(3, 2);
  EXPECT_TRUE(evaluate(problem, vec({2})).solved);
  const Errors none = evaluate(problem, vec({0}));
  EXPECT_EQ(none.velocity_residual_m_per_s, 1);
  EXPECT_EQ(none.velocity_residual_relative, 1);  // max|q| is 1: the offset is in the scale
  EXPECT_EQ(none.violation_m_per_s, 1);
  const Errors bounce = evaluate(falling(4, -2), vec({12}));
  EXPECT_TRUE(bounce.solved);
  const Errors out = evaluate(falling(0, -0.25), vec({0.5}));
  EXPECT_GT(out.work_gain_j, 0);  // which is what the offset asks for
  EXPECT_TRUE(out.solved && out.criterion);
}

TEST(OffsetTest, TheoryPromisesASolutionOnlyWithoutANegativeOffset) {
  EXPECT_EQ(Evaluator(falling(3, 2)).truth(), Truth::kSolvable);
  EXPECT_EQ(Evaluator(falling(3, 0)).truth(), Truth::kSolvable);
  EXPECT_EQ(Evaluator(falling(3, -1e-300)).truth(), Truth::kUnknown);
}

}  // namespace
}  // namespace lcpbench::offset_test
