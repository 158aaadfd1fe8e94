// Soft contacts, w_N = N'v+ + b + r_n f_N and w_D = D'v+ + C'(offset_t + r_t C f_D) + lambda, through the rigid
// equivalent, solvers, verdicts, certificates and files.
#include "core/compliance.h"

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/answer/farkas.h"
#include "core/error.h"
#include "core/io/problem_io.h"
#include "core/registry.h"
#include "core/round_cone.h"
#include "generators/changed.h"
#include "generators/sets.h"
#include "study/certify/certificate.h"
#include "tests/certify/checked_proofs.h"
#include "tests/certify/natives.h"
#include "tests/support/evaluation_cases.h"

namespace lcpbench::compliance_test {
namespace {

using testing::native_names;
using testing::solve;

Vector velocity_of(const Problem& problem, const std::string& solver = "contact_lemke") {
  const Answer answer = solve(solver, problem);
  EXPECT_EQ(answer.claim, Claim::kSolved) << solver << ": " << answer.detail;
  if (answer.z.size() != problem.size()) return Vector::Constant(problem.contact()->ngc(), kNan);
  EXPECT_TRUE(Evaluator(problem).errors(answer).solved);
  return post_impact_velocity(*problem.contact(), answer.z);
}

/// A particle of mass 2 that slides on the ground and is pressed against it; D = T C with the polygon's directions.
ContactProblem sliding(int edges, double r_n, double r_t) {
  ContactProblem contact;
  contact.v = vec({1, 0, -3});
  contact.N = Matrix(vec({0, 0, 1}));
  Matrix D(3, edges);
  for (int k = 0; k < edges; ++k) {
    const auto [x, y] = edge_direction(k, edges);
    D.col(k) << x, y, 0;
  }
  contact.D = D;
  contact.edges = {edges};
  contact.mu = vec({0.8});
  contact.inertia = DenseInertia{2 * Matrix::Identity(3, 3)};
  contact.compliance_n = vec({r_n});
  contact.compliance_t = vec({r_t});
  return contact;
}

/// Problems of a random set with compliance and tangential offsets.
ContactProblem softened(const std::string& set, std::int64_t trial, Draw& draw) {
  ContactProblem contact = *open_set(set)->generate(7, trial).contact();
  const auto size = [&] { return std::abs(draw.uniform()) < 0.3 ? 0.0 : std::abs(draw.uniform()); };
  contact.compliance_n = contact.compliance_t = Vector::Zero(contact.nc());
  contact.offset_t = Vector::Zero(2 * contact.nc());
  for (Index i = 0; i < contact.nc(); ++i) {
    contact.compliance_n(i) = size();
    if (contact.edges[static_cast<std::size_t>(i)] == 0) continue;
    contact.compliance_t(i) = size();
    contact.offset_t.segment<2>(2 * i) = 0.1 * draw.vector(2);
  }
  return contact;
}

TEST(ComplianceTest, StandsOnTheDiagonalAndInTheBlockOfFriction) {
  ContactProblem contact = sliding(4, 0.25, 0.5);
  contact.offset_t = vec({2, -4});
  const Lcp lcp = form_lcp(contact);
  EXPECT_DOUBLE_EQ(lcp.M(0, 0), 0.75);
  EXPECT_DOUBLE_EQ(lcp.M(1, 1), 1.0);
  EXPECT_EQ(lcp.M(1, 2), 0.0);
  EXPECT_DOUBLE_EQ(lcp.M(1, 3), -1.0);
  EXPECT_EQ(lcp.q, vec({-3, 1 + 2, -4, -1 - 2, 4, 0}));
}

TEST(ComplianceTest, ActsOnTheNetImpulseSoThatMoreEdgesDoNotStiffenAContact) {
  const double four = velocity_of({"4", sliding(4, 0.1, 0.5)})(0);
  for (const int edges : {8, 16, 32}) {
    EXPECT_NEAR(velocity_of({std::to_string(edges), sliding(edges, 0.1, 0.5)})(0), four, 1e-10);
  }
  EXPECT_NEAR(four, 0.5, 1e-12);  // v + f / m = -r_t f holds it back: f = -1 / (1/2 + 1/2)
}

TEST(ComplianceTest, TheRigidEquivalentHasTheSameMatrix) {
  Draw draw(1);
  for (const char* set : {"rigid/frictional/exp1{bodies_max=2,nc_max=5}", "rigid/exp1{nc_max=8}",
                          "paper/copositive/exp1{nc_max=4}", "paper/copositive/exp3{nc_max=4}"}) {
    for (std::int64_t trial = 0; trial < 5; ++trial) {
      ContactProblem contact = softened(set, trial, draw);
      for (const bool given : {false, true}) {
        if (given) contact.inertia = InverseInertia{inverse_inertia(contact.inertia)};
        SCOPED_TRACE(set);
        const Lcp lcp = form_lcp(contact);
        const Lcp rigid = form_lcp(rigid_equivalent(contact));
        EXPECT_FALSE(rigid_equivalent(contact).is_soft());
        EXPECT_LE((lcp.M - rigid.M).cwiseAbs().maxCoeff(), 1e-9 * lcp.M.cwiseAbs().maxCoeff());
        EXPECT_LE((lcp.q - rigid.q).cwiseAbs().maxCoeff(), 1e-13);
      }
    }
  }
}

TEST(ComplianceTest, EveryNativeSolverLandsOnSoftGround) {
  ContactProblem contact = frictionless(vec({0.5, -3}), Matrix(vec({0, 1})), DenseInertia{2 * Matrix::Identity(2, 2)});
  contact.compliance_n = vec({0.25});
  for (const std::string& solver : native_names()) {
    SCOPED_TRACE(solver);
    const Answer answer = solve(solver, {"soft", contact});
    EXPECT_EQ(answer.claim, Claim::kSolved) << answer.detail;
    ASSERT_EQ(answer.z.size(), 1);
    EXPECT_NEAR(answer.z(0), 4, 1e-4);  // -3 + f / 2 + f / 4 = 0
    if (answer.velocity.size() > 0) {
      ASSERT_EQ(answer.velocity.size(), 2);
      EXPECT_NEAR(answer.velocity(1), -1, 1e-4);
    }
  }
}

// Two walls that ask a box to leave both at once have no impulses as rigid ones, and some as soon as both give way.
TEST(ComplianceTest, WhereEveryContactYieldsThereIsASolution) {
  Matrix N(2, 2);
  N << 1, -1, 0, 0;
  ContactProblem contact = frictionless(vec({0, 0}), N, BlockInertia{{Matrix::Identity(2, 2)}});
  contact.b = vec({-1, -1});
  const Problem hard("hard", contact);
  const Vector push = vec({1, 1});
  EXPECT_TRUE(proves_unsolvable(*hard.contact(), push));
  EXPECT_EQ(Evaluator(hard).truth(), Truth::kUnknown);
  for (const double r : {0x1p-40, 1e-3, 1.0}) {
    contact.compliance_n = vec({r, r});
    const Problem soft("soft", contact);
    EXPECT_FALSE(proves_unsolvable(*soft.contact(), push));
    EXPECT_EQ(Evaluator(soft).truth(), Truth::kSolvable);
    const Certificate certificate = Certifier({.time_limit_s = 20}).certify(soft);
    EXPECT_EQ(certificate.kind, CertificateKind::kSolution);
    testing::expect_proof(soft, certificate);
  }
  contact.compliance_n = vec({1, 0});
  EXPECT_FALSE(proves_unsolvable(contact, push));
  contact.compliance_n = vec({1, 1});
  EXPECT_TRUE(every_contact_yields(contact));
  contact.compliance_t = Vector::Constant(2, std::numeric_limits<double>::infinity());
  EXPECT_FALSE(every_contact_yields(contact));
}

TEST(ComplianceTest, CertificatesAreOfRItself) {
  Draw draw(3);
  int solved = 0;
  for (const char* set : {"rigid/frictional/exp1{bodies_max=2,nc_max=4}", "paper/copositive/exp1{nc_max=3}",
                          "paper/copositive/exp3{nc_max=3}", "paper/monotone/exp3{nc_max=6}"}) {
    for (std::int64_t trial = 0; trial < 6; ++trial) {
      const Problem problem(set, softened(set, trial, draw));
      const Certificate certificate = Certifier({.time_limit_s = 20}).certify(problem);
      testing::expect_proof(problem, certificate);
      if (certificate.z.size() == 0) continue;
      ++solved;
      EXPECT_LE(evaluate(problem, certificate.z).velocity_residual_relative, 1e-9);
      ContactProblem other = *problem.contact();
      other.compliance_n.array() += 0.5;
      if (certificate.z.head(other.nc()).maxCoeff() <= 0) continue;
      EXPECT_GT(evaluate({"other", other}, certificate.z).velocity_residual_relative, 1e-6);
    }
  }
  EXPECT_GE(solved, 20);
}

TEST(ComplianceTest, FilesKeepItAndHardOnesKeepTheirBytesAndHashes) {
  ContactProblem contact = sliding(4, 0.25, 0.5);
  contact.offset_t = vec({0.1, 0});
  const Problem soft("soft", contact);
  const Problem read = parse_problem_json(problem_json(soft), "file");
  EXPECT_EQ(problem_hash(read), problem_hash(soft));
  EXPECT_EQ(problem_json(read), problem_json(soft));
  ContactProblem hard = contact;
  hard.compliance_n = hard.compliance_t = hard.offset_t = Vector();
  ContactProblem zero = hard;
  zero.compliance_n = zero.compliance_t = Vector::Zero(1);
  zero.offset_t = Vector::Zero(2);
  EXPECT_EQ(problem_hash({"p", hard}), problem_hash({"p", zero}));
  EXPECT_EQ(problem_json({"p", hard}), problem_json({"p", zero}));
  EXPECT_EQ(problem_json({"p", hard}).find("compliance"), std::string::npos);
  for (const int field : {0, 1, 2}) {
    ContactProblem other = contact;
    (field == 0 ? other.compliance_n : field == 1 ? other.compliance_t : other.offset_t)(0) *= 2;
    EXPECT_NE(problem_hash({"p", other}), problem_hash({"p", contact}));
  }
}

TEST(ComplianceTest, ScenesHaveItByContact) {
  RigidScene scene;
  scene.bodies.emplace_back();
  scene.contacts.push_back({.mu = 0.5, .edges = 4, .compliance_n = 0.5, .compliance_t = 0.25});
  scene.contacts.push_back({.edges = 0});
  scene.contacts[0].offset_t << 0, 3;
  const Problem problem("scene", scene);
  EXPECT_EQ(problem.contact()->compliance_n, vec({0.5, 0}));
  EXPECT_EQ(problem.contact()->compliance_t, vec({0.25, 0}));
  EXPECT_EQ(problem.contact()->offset_t, vec({0, 3, 0, 0}));
  EXPECT_EQ(problem_hash(parse_problem_json(problem_json(problem), "file")), problem_hash(problem));
  EXPECT_NE(why_not({.needs = Needs::kScene}, problem), "");
  EXPECT_EQ(why_not({.needs = Needs::kScene, .compliance = true}, problem), "");
}

std::string refusal(ContactProblem contact) {
  try {
    problem_json({"p", std::move(contact)});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ComplianceTest, BadNumbersAreNamed) {
  ContactProblem contact = sliding(4, 0.25, 0.5);
  contact.compliance_n(0) = -1;
  EXPECT_EQ(refusal(contact), "p: compliance_n[0] is -1, expected a number >= 0");
  contact = sliding(4, 0.25, 0.5);
  contact.offset_t = vec({1});
  EXPECT_NE(refusal(contact).find("offset_t"), std::string::npos);
  ContactProblem bare = frictionless(vec({0, -3}), Matrix(vec({0, 1})), DenseInertia{Matrix::Identity(2, 2)});
  bare.compliance_t = vec({1});
  EXPECT_EQ(refusal(bare), "p: compliance_t[0] is not 0, but the contact has no edges");
}

}  // namespace
}  // namespace lcpbench::compliance_test
