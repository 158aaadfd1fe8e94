// Certificates of contacts with bounded rows: mechanisms worked out by hand, every kind of proof, and random problems.
// Each proof is checked again by study/check_certificates.py, which shares no code with what made it.

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "study/certificates/certify_store.h"
#include "tests/certify/checked_proofs.h"
#include "tests/support/bounded_rows.h"
#include "tests/support/evaluation_cases.h"

namespace lcpbench::certify_rows_test {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

using testing::Row, testing::with_rows;

/// Without contacts. @param masses  of the coordinates
Problem rows_alone(const std::vector<double>& v, const std::vector<double>& masses, const std::vector<Row>& rows) {
  const auto n = static_cast<Index>(v.size());
  const Vector velocity = Eigen::Map<const Vector>(v.data(), n), mass = Eigen::Map<const Vector>(masses.data(), n);
  return {"rows", with_rows(frictionless(velocity, Matrix(n, 0), DenseInertia{Matrix(mass.asDiagonal())}), rows)};
}

Certificate certify(const Problem& problem) {
  Certificate certificate = Certifier({}).certify(problem);
  testing::expect_proof(problem, certificate);
  return certificate;
}

using Fractions = std::vector<std::string>;

void expect_solution(const Problem& problem, const Fractions& z, const Fractions& velocity) {
  const Certificate certificate = certify(problem);
  ASSERT_EQ(certificate.kind, CertificateKind::kSolution) << certificate.detail;
  EXPECT_EQ(certificate.proof, ProofKind::kExactBasis);
  EXPECT_EQ(fractions(certificate.exact_z), z);
  EXPECT_EQ(fractions(certificate.exact_velocity), velocity);
  EXPECT_EQ(certificate.velocity_unique, true);
}

TEST(CertifyRowsTest, EveryKindOfRowHasItsImpulseWorkedOutByHand) {
  expect_solution(rows_alone({1, 0}, {1, 2}, {{{1, -1}}}), {"-2/3"}, {"1/3", "1/3"});  // coupler
  expect_solution(rows_alone({-1}, {2}, {{{1}, 0, kNone, 0.25}}), {"3/2"}, {"-1/4"});  // limit
  expect_solution(rows_alone({1}, {2}, {{{1}, -kNone, 0, -0.25}}), {"-3/2"}, {"1/4"});  // the other
  expect_solution(rows_alone({1}, {2}, {{{1}, -0.5, 0.5}}), {"-1/2"}, {"3/4"});  // slides
  expect_solution(rows_alone({0.125}, {2}, {{{1}, -0.5, 0.5}}), {"-1/4"}, {"0"});  // sticks
  expect_solution(rows_alone({0}, {1}, {{{1}, -0.25, 0.75, -4}}), {"3/4"}, {"3/4"});  // motor
  expect_solution(rows_alone({1}, {1}, {{{1}, -kNone, kNone, 0, 2}}), {"-1/3"}, {"2/3"});  // soft
  expect_solution(rows_alone({1}, {1}, {{{1}, -0.5, 3, 1, 0.5}}), {"-1/2"}, {"1/2"});  // soft, at its bound
}

// A limit carries 2 N s, and the friction of a screw on it holds 1/4 of that at most.
TEST(CertifyRowsTest, FrictionOfARowGrowsWithItsLoad) {
  const Problem slides = rows_alone({-2, 1}, {1, 1}, {{{1, 0}, 0}, {{0, 1}, -kNone, kNone, 0, 0, 0, 0.25}});
  const Certificate sliding = certify(slides);
  EXPECT_EQ(fractions(sliding.exact_z), (Fractions{"2", "-1/2"}));
  EXPECT_EQ(fractions(sliding.exact_velocity), (Fractions{"0", "1/2"}));
  EXPECT_FALSE(sliding.velocity_unique.has_value());  // nothing says so of friction
  const Problem sticks = rows_alone({-2, 1}, {1, 1}, {{{1, 0}, 0}, {{0, 1}, -kNone, kNone, 0, 0, 0, 0.75}});
  EXPECT_EQ(fractions(certify(sticks).exact_z), (Fractions{"2", "-1"}));
}

TEST(CertifyRowsTest, EveryFormOfTheInertiaGivesTheSameMotion) {
  const Matrix G = vec({2, 4}).asDiagonal();
  ContactProblem contact = frictionless(vec({-1, 0.5}), Matrix(vec({1, 0})), DenseInertia{G});
  contact = with_rows(std::move(contact), {{{1, -1}, -0.25, 0.5}});
  const Fractions z{"3/2", "1/2"}, velocity{"0", "3/8"};
  expect_solution({"dense", contact}, z, velocity);
  contact.inertia = FactoredInertia{Matrix::Identity(2, 2), vec({2, 4})};
  expect_solution({"factors", contact}, z, velocity);
  contact.inertia = InverseInertia{Matrix(vec({0.5, 0.25}).asDiagonal())};
  expect_solution({"inverse", contact}, z, velocity);
}

TEST(CertifyRowsTest, RedundantEqualitiesHaveOneVelocityAndContradictoryOnesNone) {
  const std::vector<Row> twice{{{1, 1}}, {{-1, -1}}};
  const Certificate redundant = certify(rows_alone({1, 2}, {1, 1}, twice));
  EXPECT_EQ(fractions(redundant.exact_velocity), (Fractions{"-1/2", "1/2"}));
  EXPECT_EQ(redundant.velocity_unique, true);
  const Problem contradict = rows_alone({1, 2}, {1, 1}, {{{1, 1}}, {{-1, -1}, -kNone, kNone, 0.5}});
  const Certificate none = certify(contradict);
  EXPECT_EQ(none.kind, CertificateKind::kUnsolvable);
  EXPECT_EQ(none.proof, ProofKind::kFarkas);
  ASSERT_EQ(none.farkas.size(), 2);
  EXPECT_EQ(none.farkas(0), none.farkas(1));
  EXPECT_EQ(least_violation(contradict, none), 0.25);  // 0.5 / (1 + 1), by halves
  const Certificate soft = certify(rows_alone({1, 2}, {1, 1}, {{{1, 1}}, {{-1, -1}, -kNone, kNone, 0.5, 0.125}}));
  EXPECT_EQ(soft.kind, CertificateKind::kSolution);
}

// A contact that must part at 1 m/s, and a stop that forbids it.
TEST(CertifyRowsTest, AContactAndALimitMayContradictEachOther) {
  ContactProblem contact = frictionless(vec({0}), Matrix(vec({1})), DenseInertia{Matrix(vec({1}))});
  contact.b = vec({-1});
  const Problem blocked("blocked", with_rows(contact, {{{1}, -kNone, 0}}));
  const Certificate none = certify(blocked);
  EXPECT_EQ(none.proof, ProofKind::kFarkas);
  EXPECT_EQ(none.farkas, vec({1, -1}));
  const Problem yields("yields", with_rows(contact, {{{1}, -2, 0}}));
  EXPECT_EQ(certify(yields).kind, CertificateKind::kSolution);
}

// A stop has to throw its body back at 1 m/s, and friction of twice its impulse holds the body.
TEST(CertifyRowsTest, TryingEveryBasisProvesThatFrictionLeavesNoSolution) {
  const auto thrown = [](double mu) {
    return rows_alone({0}, {1}, {{{1}, 0, kNone, -1}, {{1}, -kNone, kNone, 0, 0, 0, mu}});
  };
  const Certificate none = certify(thrown(2));
  EXPECT_EQ(none.kind, CertificateKind::kUnsolvable) << none.detail;
  EXPECT_EQ(none.proof, ProofKind::kEveryBasis);
  EXPECT_EQ(fractions(certify(thrown(0.5)).exact_z), (Fractions{"2", "-1"}));
}

/// What study/check_certificates.py says of a proof in which `from` is replaced.
std::string checked(std::string proof, const std::string& from, const std::string& to) {
  const std::size_t at = proof.find(from);
  EXPECT_NE(at, std::string::npos) << from << " in " << proof;
  if (at != std::string::npos) proof.replace(at, from.size(), to);
  const ScratchFolder folder;
  std::ofstream(folder / "proof.jsonl") << proof << "\n";
  const std::string out = folder / "out";
  const std::string command = CHECK_CERTIFICATES " '" + (folder / "proof.jsonl").string() + "' >'" + out + "' 2>&1";
  EXPECT_EQ(std::system(command.c_str()) != 0, from != to);
  return read_file(out);
}

TEST(CertifyRowsTest, TheCheckerRejectsProofsThatBoundsForbid) {
  const Problem slides = rows_alone({1}, {2}, {{{1}, -0.5, 0.25}});
  const std::string solution = proof_document(slides, certify(slides));
  EXPECT_NE(checked(solution, "-0.5", "-0.5").find("1 accepted"), std::string::npos);
  EXPECT_NE(checked(solution, "-0.5", "-0.375").find("below its lower bound"), std::string::npos);
  EXPECT_NE(checked(solution, "-0.5", "-0.75").find("w > 0 above its lower bound"), std::string::npos);
  const Problem contradict = rows_alone({1, 2}, {1, 1}, {{{1, 1}}, {{-1, -1}, -kNone, kNone, 0.5}});
  const std::string none = proof_document(contradict, certify(contradict));
  EXPECT_NE(checked(none, "[null,null]", "[null,null]").find("1 accepted"), std::string::npos);
  EXPECT_NE(checked(none, R"("lower":[null,null])", R"("lower":[-8,-8])").find("which has a bound"), std::string::npos);
  EXPECT_NE(checked(none, R"("b":[0,0.5])", R"("b":[0,0.5],"compliance":[0,1])").find("yields"), std::string::npos);
  EXPECT_NE(checked(none, R"("b":[0,0.5])", R"("b":[0,0])").find("not negative"), std::string::npos);
}

// Small whole numbers, so that ties, redundant rows and contradictions are frequent.
TEST(CertifyRowsTest, RandomProblemsAreDecidedAndNoSolverContradictsTheProof) {
  Draw draw(87);
  const auto integer = [&](std::uint64_t below) { return static_cast<double>(draw.bits() % below); };
  const std::unique_ptr<Solver> solver = make_solver(parse_spec("auto"));
  int solutions = 0, none = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Index ngc = 1 + static_cast<Index>(integer(3)), nc = static_cast<Index>(integer(3));
    Matrix N(ngc, nc);
    for (double& x : N.reshaped()) x = integer(3) - 1;
    Vector v(ngc), b(nc), masses(ngc);
    for (double& x : v) x = integer(5) - 2;
    for (double& x : b) x = integer(3) - 1;
    for (double& x : masses) x = integer(3) + 1;
    ContactProblem contact = frictionless(v, N, DenseInertia{Matrix(masses.asDiagonal())});
    if (nc > 0) contact.b = b;
    std::vector<Row> rows(1 + static_cast<std::size_t>(integer(3)));
    for (std::size_t i = 0; i < rows.size(); ++i) {
      Row& row = rows[i];
      for (Index k = 0; k < ngc; ++k) row.direction.push_back(integer(3) - 1);
      row.b = integer(3) - 1;
      row.compliance = integer(4) == 0 ? 0.5 : 0;
      const double kind = integer(5);
      if (kind == 1 || kind == 3) row.lower = kind == 3 ? -integer(3) - 1 : 0;
      if (kind == 2 || kind == 3) row.upper = integer(3);
      if (kind == 4 && i > 0 && rows[0].lower == 0) {
        row.friction_of = 0;
        row.mu = integer(4) / 2;
      }
    }
    const Problem problem("random", with_rows(std::move(contact), rows));
    const Certificate certificate = certify(problem);
    EXPECT_NE(certificate.kind, CertificateKind::kOpen) << trial << ": " << certificate.detail;
    TimedAnswer timed;
    timed_solve(*solver, problem, {}, timed);
    const bool is_solved = evaluate(problem, timed.answer.z).solved;
    if (certificate.kind == CertificateKind::kSolution) {
      ++solutions;
      EXPECT_TRUE(evaluate(problem, certificate.z).solved) << trial;
      EXPECT_NE(timed.answer.claim, Claim::kUnsolvable) << trial;
    } else {
      ++none;
      EXPECT_FALSE(is_solved) << trial;
    }
  }
  EXPECT_GT(solutions, 100);
  EXPECT_GT(none, 20);
}

}  // namespace
}  // namespace lcpbench::certify_rows_test
