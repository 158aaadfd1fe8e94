// Bullet's Dantzig solver called from here, as its header says, against the adapter's answers: on the same problems the
// same bits and the same word, so that a share of `bullet_dantzig` is the library's and not the adapter's.
#include <cstring>
#include <vector>

#include <BulletDynamics/MLCPSolvers/btDantzigLCP.h>
#include <gtest/gtest.h>

#include "generators/sets.h"
#include "study/run/open_solver.h"

namespace lcpbench {
namespace {

constexpr int kTrials = 200;

struct Direct {
  bool solved;
  std::vector<double> z;
};

// A z = b + w, z >= 0: n numbers after n numbers, all of it overwritten by the library. It asks for a symmetric A and
// reads one triangle; M is symmetric but for rounding, and both sides here give the columns of M.
Direct call_bullet(const Lcp& lcp) {
  const int n = static_cast<int>(lcp.size());
  const auto count = static_cast<std::size_t>(n);
  std::vector<double> A;
  std::vector<double> b;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) A.push_back(lcp.M(j, i));
    b.push_back(-lcp.q(i));
  }
  std::vector<double> z(count, 0.0);
  std::vector<double> w(count, 0.0);
  std::vector<double> low(count, 0.0);
  std::vector<double> high(count, BT_INFINITY);
  std::vector<int> friction(count, -1);
  btDantzigScratchMemory fresh;
  const bool solved =
      btSolveDantzigLCP(n, A.data(), z.data(), b.data(), w.data(), 0, low.data(), high.data(), friction.data(), fresh);
  return {solved, z};
}

class BulletDirect : public ::testing::TestWithParam<const char*> {};

TEST_P(BulletDirect, TheAdapterGivesTheLibrarysBits) {
  const auto set = open_set(GetParam());
  const auto bullet = open_solver(parse_spec("bullet_dantzig"));
  int refused = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Problem problem = set->generate(1016, trial);
    const Direct direct = call_bullet(problem.lcp());
    TimedAnswer adapted;
    bullet->run(problem, {}, adapted);
    EXPECT_EQ(adapted.answer.claim, direct.solved ? Claim::kSolved : Claim::kNumericalFailure) << trial;
    ASSERT_EQ(adapted.answer.z.size(), problem.size()) << trial;
    EXPECT_EQ(std::memcmp(adapted.answer.z.data(), direct.z.data(), direct.z.size() * sizeof(double)), 0) << trial;
    refused += !direct.solved;
  }
  EXPECT_GT(refused, kTrials / 20) << "too easy a set to tell the two words apart";
}

INSTANTIATE_TEST_SUITE_P(Sets, BulletDirect,
                         ::testing::Values("paper/monotone/exp1", "paper/monotone/exp2{redundancy=combination}",
                                         "paper/monotone/exp3", "paper/monotone/exp5-1e8{redundancy=combination}"));

}  // namespace
}  // namespace lcpbench
