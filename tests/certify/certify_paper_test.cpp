#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "generators/sets.h"
#include "study/certify/certificate.h"
#include "study/evaluation/evaluation.h"
#include "tests/certify/certificate_check.h"

namespace lcpbench {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr int kMonotone = 40, kCopositive = 8;

struct Tally {
  int solution = 0;
  int unsolvable = 0;
  int by_lp = 0;
  int open = 0;
};

/// What other solvers are known to be right about never contradicts the certificate, nor does its own z, rounded.
void expect_no_contradiction(const Problem& problem, const Certificate& certificate, Solver& solver) {
  Evaluator evaluator(problem);
  Answer answer;
  solver.load(problem);
  solver.solve({}, answer);
  const bool proven_unsolvable = answer.farkas.size() > 0 && evaluator.check_farkas(answer.farkas);
  EXPECT_TRUE(!proven_unsolvable || certificate.kind == CertificateKind::kUnsolvable);
  EXPECT_TRUE(evaluator.truth() != Truth::kSolvable || certificate.kind == CertificateKind::kSolution);
  if (certificate.proof == ProofKind::kExactBasis) {
    answer.z = certificate.z;
    EXPECT_TRUE(evaluator.errors(answer).solved);
  }
}

/// Where every problem has its proof, the time limit is only a net.
constexpr CertifyOptions kPatient{.time_limit_s = 600};

Tally certify_set(const std::string& name, int trials, const char* solver_name, const CertifyOptions& options) {
  const std::unique_ptr<ProblemSet> set = open_set(name);
  const std::unique_ptr<Solver> solver = make_solver({solver_name, {}});
  Certifier certifier(options);
  Tally tally;
  for (int trial = 0; trial < trials; ++trial) {
    SCOPED_TRACE(name + " " + std::to_string(trial));
    const Problem problem = set->generate(kSeed, trial);
    const Certificate certificate = certifier.certify(problem);
    testing::expect_proof(problem, certificate);
    expect_no_contradiction(problem, certificate, *solver);
    tally.solution += certificate.kind == CertificateKind::kSolution ? 1 : 0;
    tally.unsolvable += certificate.kind == CertificateKind::kUnsolvable ? 1 : 0;
    tally.by_lp += certificate.proof == ProofKind::kLp ? 1 : 0;
    tally.open += certificate.kind == CertificateKind::kOpen ? 1 : 0;
  }
  return tally;
}

class CertifyMonotoneTest : public ::testing::TestWithParam<const char*> {};

TEST_P(CertifyMonotoneTest, NoProblemIsLeftOpenAndFullRankOnesAreSolved) {
  const std::string name = GetParam();
  const Tally tally = certify_set(name, kMonotone, "active_set", kPatient);
  EXPECT_EQ(tally.open, 0);
  EXPECT_EQ(tally.by_lp, 0);
  const bool reduced = name.find("exp3") != std::string::npos || name.find("exp4") != std::string::npos;
  if (reduced)
    EXPECT_GT(tally.unsolvable, 0);
  else
    EXPECT_EQ(tally.solution, kMonotone);
}

INSTANTIATE_TEST_SUITE_P(PaperSets, CertifyMonotoneTest,
                         ::testing::Values("paper/monotone/exp1", "paper/monotone/exp2",
                                           "paper/monotone/exp2{redundancy=combination}", "paper/monotone/exp3",
                                           "paper/monotone/exp4", "paper/monotone/exp4{redundancy=combination}",
                                           "paper/monotone/exp5-1e10",
                                           "paper/monotone/exp5-1e10{redundancy=combination}"));

class CertifyCopositiveTest : public ::testing::TestWithParam<const char*> {};

TEST_P(CertifyCopositiveTest, FullRankProblemsAreSolvedAndReducedOnesMostlyDecided) {
  const std::string name = GetParam();
  const bool reduced = name.find("exp3") != std::string::npos || name.find("exp4") != std::string::npos;
  const Tally tally = certify_set(name, kCopositive, "contact_lemke", reduced ? CertifyOptions{} : kPatient);
  if (reduced)
    EXPECT_LT(2 * tally.open, kCopositive);
  else
    EXPECT_EQ(tally.solution, kCopositive);
}

INSTANTIATE_TEST_SUITE_P(PaperSets, CertifyCopositiveTest,
                         ::testing::Values("paper/copositive/exp1", "paper/copositive/exp2",
                                           "paper/copositive/exp2{redundancy=combination}", "paper/copositive/exp3",
                                           "paper/copositive/exp4", "paper/copositive/exp4{redundancy=combination}"));

}  // namespace
}  // namespace lcpbench
