#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "study/report/solver_comparison.h"

namespace lcpbench {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// One outcome by its sign: 'S' solved, '.' unsolved and said so, '!' unsolved and claimed, 'r' refused, 'u'
/// unsolvable, ' ' not met.
Outcome outcome_of(char sign, std::int64_t problem, double time_s) {
  Outcome outcome{.problem = problem, .trial = problem};
  outcome.solved = sign == 'S';
  outcome.false_claim = sign == '!';
  outcome.unsolvable = sign == 'u';
  outcome.refused = sign == 'r';
  outcome.time_s = sign == 'r' ? kNone : time_s;
  outcome.error = sign == 'S' ? 1e-12 : sign == '!' ? 0.5 : kNone;
  return outcome;
}

void count(char sign, Cell& cell) {
  const auto [claim, verdict] = sign == 'S'   ? std::pair(Claim::kSolved, Verdict::kSolved)
                                : sign == '!' ? std::pair(Claim::kSolved, Verdict::kWrong)
                                : sign == 'r' ? std::pair(Claim::kUnsupported, Verdict::kRefused)
                                : sign == 'u' ? std::pair(Claim::kIterationLimit, Verdict::kUnsolvable)
                                              : std::pair(Claim::kIterationLimit, Verdict::kMissed);
  ++cell.trials;
  if (sign == 'u') ++cell.unsolvable_problems;
  ++cell.counts[static_cast<std::size_t>(claim)][static_cast<std::size_t>(verdict)];
}

/// A summary of one set, whose solvers answer as their signs say.
class MadeSummary {
 public:
  explicit MadeSummary(std::int64_t problems) {
    summary_.sets.resize(1);
    summary_.sets[0].name = "set";
    summary_.sets[0].problems = problems;
  }

  void solver(const std::string& name, const std::string& signs, const std::vector<double>& times = {},
              double verify_s = 0) {
    Cell cell;
    cell.solver = summary_.solvers.size();
    SolverRow row;
    row.name = name;
    summary_.solvers.push_back(row);
    cell.time_parts.verify = verify_s;
    for (std::size_t i = 0; i < signs.size(); ++i) {
      if (signs[i] == ' ') continue;
      count(signs[i], cell);
      cell.outcomes.push_back(outcome_of(signs[i], static_cast<std::int64_t>(i), times.empty() ? 1 : times[i]));
    }
    summary_.cells.push_back(cell);
  }

  Summary& summary() { return summary_; }
  SetComparison compare() const { return compare_solvers(summary_).at(0); }

 private:
  Summary summary_;
};

TEST(ComparisonTest, PairsCountProblemsThatBothTook) {
  MadeSummary made(9);
  made.solver("a", "SSS.!u S ");
  made.solver("b", "S..S.uSSr");
  const SetComparison comparison = made.compare();
  ASSERT_EQ(comparison.pairs.size(), 1U);
  const ComparedPair& pair = comparison.pairs[0];
  EXPECT_EQ(pair.solved.problems(), 7);
  EXPECT_EQ(pair.solved.both, 2);
  EXPECT_EQ(pair.solved.only_first, 2);
  EXPECT_EQ(pair.solved.only_second, 1);
  EXPECT_EQ(pair.solved.neither, 2);
  EXPECT_DOUBLE_EQ(pair.p, mcnemar_exact(2, 1));
}

TEST(ComparisonTest, RefusedProblemsAreNoPairs) {
  MadeSummary made(3);
  made.solver("a", "SrS");
  made.solver("b", "S.r");
  EXPECT_EQ(made.compare().pairs.at(0).solved.problems(), 1);
}

/// 7 : 0 has p = 0.016, significant alone; among three pairs it is not, and the word must not be said.
TEST(ComparisonTest, WordsNeedTheCorrectedTest) {
  MadeSummary alone(7);
  alone.solver("a", "SSSSSSS");
  alone.solver("b", ".......");
  ASSERT_TRUE(alone.compare().pairs.at(0).better().has_value());
  EXPECT_EQ(*alone.compare().pairs[0].better(), 0U);
  MadeSummary several(7);
  several.solver("a", "SSSSSSS");
  several.solver("b", ".......");
  several.solver("c", "SSSS...");
  const std::vector<ComparedPair> pairs = several.compare().pairs;
  ASSERT_EQ(pairs.size(), 3U);
  EXPECT_LT(pairs[0].p, 0.05);
  EXPECT_DOUBLE_EQ(pairs[0].p_holm, 3 * pairs[0].p);
  EXPECT_EQ(pairs[0].better(), std::optional<std::size_t>(0)) << "0.047 after correction";
  several.solver("d", "SSSS...");
  const std::vector<ComparedPair> more = several.compare().pairs;
  EXPECT_DOUBLE_EQ(more[0].p_holm, 6 * more[0].p);
  EXPECT_EQ(more[0].better(), std::nullopt) << "0.094 after correction";
}

TEST(ComparisonTest, EcdfEndsAtTheShareSolvedOfWhatIsSolvable) {
  MadeSummary made(6);
  made.solver("a", "SS.r!u", {1e-3, 1, 2, 0, 3, 4});
  const SetComparison comparison = made.compare();
  const Distribution& distribution = comparison.distributions.at(0);
  EXPECT_EQ(distribution.problems, 5);
  EXPECT_EQ(distribution.solved_within(std::vector<double>{1e-4, 1e-3, 0.5, 1, 1e9}),
            (std::vector<double>{0, 0.2, 0.2, 0.4, 0.4}));
  EXPECT_EQ(distribution.answered_within(std::vector<double>{1e-13, 1e-4, 1, 1e300}),
            (std::vector<double>{0, 0.4, 0.6, 0.6}));
}

TEST(ComparisonTest, TimesWeighFailures) {
  MadeSummary made(5);
  made.summary().runs.push_back({"", {{"plan", {{"time_limit_s", 10}}}}});
  made.solver("a", "SS.ru", {1, 3, 7, 0, 9});
  const SetComparison comparison = made.compare();
  const SolverTimes& times = comparison.times.at(0);
  EXPECT_EQ(times.problems, 4);
  EXPECT_EQ(times.solved, 2);
  EXPECT_EQ(times.timed, 4);
  EXPECT_DOUBLE_EQ(times.par10, (1 + 3 + 2 * 100) / 4.0);
  EXPECT_DOUBLE_EQ(times.geometric_mean.value,
                   shifted_geometric_mean(std::vector<double>{1, 3, 7, 9}, kTimeShift).value);
}

TEST(ComparisonTest, WithoutARecordedLimitFailuresHaveNoPar10) {
  MadeSummary made(2);
  made.solver("fails", "S.");
  made.solver("solves", "SS");
  EXPECT_TRUE(std::isnan(made.compare().times[0].par10));
  EXPECT_EQ(made.compare().times[1].par10, 1);
}

TEST(ComparisonTest, ProfilesArePairwise) {
  MadeSummary made(4);
  made.solver("lemke", "SSS.", {2, 2, 2, 2});
  made.solver("quick", "SS.S", {1, 8, 1, 1});
  made.summary().reference = "lemke";
  const SetComparison comparison = made.compare();
  ASSERT_EQ(comparison.profiles.size(), 1U);
  const PairProfile& profile = comparison.profiles[0];
  EXPECT_EQ(profile.problems, 4);
  EXPECT_EQ(profile.solver_shares.front(), 0.5);   // fastest on the first and the last
  EXPECT_EQ(profile.against_shares.front(), 0.5);  // on the second and the third
  EXPECT_EQ(profile.against_shares.back(), 0.75);  // never on the last, which it did not solve
  const auto two = std::find(kProfileFactors.begin(), kProfileFactors.end(), 2) - kProfileFactors.begin();
  EXPECT_EQ(profile.against_shares[static_cast<std::size_t>(two)], 0.75);
  EXPECT_EQ(profile.solver_shares[static_cast<std::size_t>(two)], 0.5);
}

/// Adding a third solver must change no pairwise profile.
TEST(ComparisonTest, AThirdSolverChangesNoProfileOfTheOthers) {
  MadeSummary two(4);
  MadeSummary three(4);
  for (MadeSummary* made : {&two, &three}) {
    made->solver("lemke", "SSS.", {2, 2, 2, 2});
    made->solver("quick", "SS.S", {1, 8, 1, 1});
    made->summary().reference = "lemke";
  }
  three.solver("fastest", "SSSS", {0.1, 0.1, 0.1, 0.1});
  EXPECT_EQ(two.compare().profiles[0].solver_shares, three.compare().profiles[0].solver_shares);
  EXPECT_EQ(two.compare().profiles[0].against_shares, three.compare().profiles[0].against_shares);
}

TEST(ComparisonTest, VirtualBestCountsWhoIsAloneAndWhoIsFastest) {
  MadeSummary made(6);
  made.solver("a", "SSS..u", {1, 5, 5, 1, 1, 1});
  made.solver("b", "SS.S.u", {2, 1, 1, 4, 1, 1});
  made.solver("sampled", "S S   ");
  const SetComparison comparison = made.compare();
  ASSERT_EQ(comparison.virtual_bests.size(), 2U);
  const VirtualBest& best = comparison.virtual_bests[0];
  EXPECT_FALSE(best.common_only);
  EXPECT_EQ(best.left_out, std::vector<std::size_t>{2});
  EXPECT_EQ(best.problems, 5);
  EXPECT_EQ(best.solved, 4);
  EXPECT_DOUBLE_EQ(best.mean_time_s, (1 + 1 + 5 + 4) / 4.0);
  EXPECT_EQ(best.contributions[0].alone, 1);
  EXPECT_EQ(best.contributions[0].fastest, 2);
  EXPECT_EQ(best.contributions[1].alone, 1);
  EXPECT_EQ(best.contributions[1].fastest, 2);
  const VirtualBest& common = comparison.virtual_bests[1];
  EXPECT_TRUE(common.common_only);
  EXPECT_EQ(common.problems, 2);
  EXPECT_EQ(common.contributions.size(), 3U);
}

/// Greedy by problems solved takes `wide` first and needs three; `left` and `right` together need two.
TEST(ComparisonTest, ChainIsShortestWhereGreedyIsNot) {
  MadeSummary made(10);
  made.solver("wide", ".SSSSSSSS.");
  made.solver("left", "SSSSS.....");
  made.solver("right", ".....SSSSS");
  const SetComparison comparison = made.compare();
  const FallbackChain& chain = comparison.virtual_bests.at(0).chain.value();
  ASSERT_EQ(chain.steps.size(), 2U);
  EXPECT_EQ(chain.steps[0].solver, 1U);
  EXPECT_EQ(chain.steps[1].solver, 2U);
  EXPECT_EQ(chain.steps[1].reached, 5);
}

/// `quick` fails on one problem and claims success there: the chain goes on, and pays for finding out.
TEST(ComparisonTest, AFalseClaimDoesNotEndTheChain) {
  MadeSummary made(4);
  made.solver("quick", "SSS!", {1, 1, 1, 1}, 0.5);
  made.solver("other", "...S", {8, 8, 8, 8}, 0.25);
  const SetComparison comparison = made.compare();
  const FallbackChain& chain = comparison.virtual_bests.at(0).chain.value();
  ASSERT_EQ(chain.steps.size(), 2U);
  EXPECT_EQ(chain.steps[0].solver, 0U);
  EXPECT_EQ(chain.steps[1].reached, 1);
  EXPECT_EQ(chain.timed, 4);
  EXPECT_DOUBLE_EQ(chain.mean_time_s, (4 * 1 + 8) / 4.0);
  EXPECT_DOUBLE_EQ(chain.mean_verification_s, (4 * 0.5 + 0.25) / 4.0);
}

TEST(ComparisonTest, NothingSolvedHasNoChain) {
  MadeSummary made(2);
  made.solver("a", "..");
  made.solver("b", "!.");
  const SetComparison comparison = made.compare();
  EXPECT_FALSE(comparison.virtual_bests.at(0).chain.has_value());
  EXPECT_EQ(comparison.virtual_bests.at(0).solved, 0);
  EXPECT_TRUE(std::isnan(comparison.virtual_bests.at(0).mean_time_s));
}

struct Reached {
  std::int64_t solved = 0;
  double mean_time_s = 0;
};

/// Walks a chain problem by problem, as its user would.
Reached walk(const Summary& summary, const std::vector<std::size_t>& order) {
  Reached reached;
  const std::size_t problems = summary.cells[0].outcomes.size();
  for (std::size_t problem = 0; problem < problems; ++problem) {
    for (const std::size_t solver : order) {
      const Outcome& outcome = summary.cells[solver].outcomes[problem];
      reached.mean_time_s += outcome.time_s / static_cast<double>(problems);
      if (!outcome.solved) continue;
      ++reached.solved;
      break;
    }
  }
  return reached;
}

/// Every ordered choice of up to five solvers, tried one by one: the chain found is as short as any that solves as
/// much, and no other of its length is cheaper.
TEST(ComparisonTest, ChainsEqualExhaustiveSearchOverAllOrders) {
  BoundedDraw draw(7);
  for (int round = 0; round < 20; ++round) {
    MadeSummary made(30);
    const std::size_t solvers = 5;
    for (std::size_t i = 0; i < solvers; ++i) {
      std::string signs;
      std::vector<double> times;
      for (int problem = 0; problem < 30; ++problem) {
        signs += draw.below(3) == 0 ? 'S' : draw.below(2) == 0 ? '.' : '!';
        times.push_back(1 + static_cast<double>(draw.below(1000)));
      }
      made.solver(std::string(1, static_cast<char>('a' + i)), signs, times);
    }
    const SetComparison comparison = made.compare();
    const VirtualBest& best = comparison.virtual_bests.at(0);
    std::size_t shortest = solvers + 1;
    double cheapest = 0;
    std::vector<std::size_t> order(solvers);
    std::iota(order.begin(), order.end(), 0U);
    do {
      for (std::size_t length = 1; length <= solvers; ++length) {
        const Reached reached =
            walk(made.summary(), {order.begin(), order.begin() + static_cast<std::ptrdiff_t>(length)});
        if (reached.solved < best.solved || length > shortest) continue;
        if (length == shortest) cheapest = std::min(cheapest, reached.mean_time_s);
        if (length < shortest) cheapest = reached.mean_time_s;
        shortest = length;
      }
    } while (std::next_permutation(order.begin(), order.end()));
    ASSERT_TRUE(best.chain.has_value());
    EXPECT_EQ(best.chain->steps.size(), shortest);
    EXPECT_NEAR(best.chain->mean_time_s, cheapest, 1e-9 * cheapest);
    const auto solved = std::accumulate(best.chain->steps.begin(), best.chain->steps.end(), std::int64_t{0},
                                        [](std::int64_t sum, const ChainStep& step) { return sum + step.solved; });
    EXPECT_EQ(solved, best.solved);
  }
}

/// One missing time must not make a chain look cheaper.
TEST(ComparisonTest, ProblemsWithAMissingTimeAreInNoMean) {
  MadeSummary made(3);
  made.solver("a", "SSS", {1, kNone, 3});
  const SetComparison comparison = made.compare();
  const VirtualBest& best = comparison.virtual_bests.at(0);
  EXPECT_EQ(best.chain.value().timed, 2);
  EXPECT_DOUBLE_EQ(best.chain->mean_time_s, 2);
  EXPECT_EQ(best.solved, 3);
}

TEST(ComparisonTest, SolversOfTheSameNameAreToldApart) {
  MadeSummary made(1);
  made.solver("lemke", "S");
  made.solver("lemke", "S");
  for (SolverRow& row : made.summary().solvers) row.library = "native";
  for (SolverRow& row : made.summary().solvers) row.version = "0.3";
  made.summary().solvers[0].isa = "avx2";
  EXPECT_EQ(solver_label(made.summary(), 0), "lemke (avx2, native 0.3)");
  made.solver("psor", "S");
  EXPECT_EQ(solver_label(made.summary(), 2), "psor");
}

}  // namespace
}  // namespace lcpbench
