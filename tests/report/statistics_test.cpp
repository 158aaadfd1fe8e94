#include "study/statistics/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/bounded_draw.h"

namespace lcpbench::statistics_test {
namespace {

/// The intervals that Newcombe (Statistics in Medicine 17, 1998, table I, method 3) prints to four digits.
TEST(StatisticsTest, WilsonMatchesNewcombesTable) {
  struct Row {
    std::int64_t successes, trials;
    double low, high;
  };
  for (const Row& row : {Row{81, 263, 0.2553, 0.3662}, Row{15, 148, 0.0624, 0.1605}, Row{0, 20, 0.0, 0.1611},
                         Row{1, 29, 0.0061, 0.1718}}) {
    const Interval interval = wilson(row.successes, row.trials);
    EXPECT_NEAR(interval.low, row.low, 5e-5) << row.successes << " of " << row.trials;
    EXPECT_NEAR(interval.high, row.high, 5e-5) << row.successes << " of " << row.trials;
  }
}

/// Its ends are the shares from which what was seen is just the quantile's number of standard errors away.
TEST(StatisticsTest, WilsonAtAnotherLevelSolvesItsOwnEquation) {
  const Interval interval = wilson(8492, 10'000, kNormal9995);
  for (const double end : {interval.low, interval.high}) {
    EXPECT_NEAR(std::abs(0.8492 - end), kNormal9995 * std::sqrt(end * (1 - end) / 10'000), 1e-12);
  }
  EXPECT_LT(interval.low, wilson(8492, 10'000).low);
}

TEST(StatisticsTest, WilsonIsClosedAtTheEndsAndNamesTheSampleSizesPower) {
  EXPECT_EQ(wilson(0, 200).low, 0.0);
  EXPECT_EQ(wilson(200, 200).high, 1.0);
  EXPECT_NEAR(wilson(200, 200).low, 0.9812, 5e-5);
  EXPECT_NEAR(wilson(20000, 20000).low, 0.99981, 5e-6);
  EXPECT_TRUE(std::isnan(wilson(0, 0).low));
  EXPECT_THROW(wilson(3, 2), std::invalid_argument);
  EXPECT_THROW(wilson(-1, 2), std::invalid_argument);
}

TEST(StatisticsTest, QuantileIsAValueThatOccurred) {
  std::vector<double> values;
  for (int i = 1; i <= 100; ++i) values.push_back(i);
  EXPECT_EQ(quantile(values, 0.99), 99);
  EXPECT_EQ(quantile(values, 0.5), 50);
  EXPECT_EQ(quantile(values, 0.001), 1);
  EXPECT_EQ(quantile(values, 1.0), 100);
  values.back() = std::numeric_limits<double>::infinity();
  EXPECT_EQ(quantile(values, 0.99), 99);
  EXPECT_TRUE(std::isinf(quantile(values, 0.995)));
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

/// 0.07 n is a whole number in the reals for n = 700, and above it in doubles.
TEST(StatisticsTest, QuantileRankIsNotPushedUpByRounding) {
  std::vector<double> values(700);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(i + 1);
  EXPECT_EQ(quantile(values, 0.07), 49);
}

TEST(StatisticsTest, SpreadOfAKnownSample) {
  const std::vector<double> values{2, 4, 4, 4, 5, 5, 7, 9};
  const Spread result = spread(values);
  EXPECT_DOUBLE_EQ(result.mean, 5);
  EXPECT_DOUBLE_EQ(result.sigma, std::sqrt(32.0 / 7));
  EXPECT_EQ(result.max, 9);
  EXPECT_EQ(result.median, 4.5);
}

TEST(StatisticsTest, SpreadOfTooFewValuesIsNotANumber) {
  EXPECT_TRUE(std::isnan(spread({}).mean));
  const std::vector<double> one{3};
  EXPECT_EQ(spread(one).mean, 3);
  EXPECT_TRUE(std::isnan(spread(one).sigma));
}

TEST(StatisticsTest, SpreadKeepsItsDigitsFarFromZero) {
  const std::vector<double> values{1e9 + 4, 1e9 + 7, 1e9 + 13, 1e9 + 16};
  EXPECT_DOUBLE_EQ(spread(values).sigma * spread(values).sigma, 30);
}

/// Chi-square over 10 faces, 100,000 draws; its 1 - 1e-6 quantile with 9 degrees of freedom is 45.1.
TEST(StatisticsTest, BoundedDrawIsUniform) {
  BoundedDraw draw(1);
  std::vector<double> counts(10, 0.0);
  for (int i = 0; i < 100000; ++i) counts[draw.below(10)] += 1;
  double chi_square = 0;
  for (const double count : counts) chi_square += (count - 10000) * (count - 10000) / 10000;
  EXPECT_LT(chi_square, 45.1);
}

/// The C++ standard fixes the 10,000th output of the default-seeded engine; a draw below 2^63 is its upper 63 bits.
TEST(StatisticsTest, BoundedDrawIsTheSameOnEveryPlatform) {
  BoundedDraw draw(5489);
  std::uint64_t last = 0;
  for (int i = 0; i < 10000; ++i) last = draw.below(std::uint64_t{1} << 63);
  EXPECT_EQ(last, std::uint64_t{9981545732273789042U} >> 1);
}

double uniform(BoundedDraw& draw) { return (static_cast<double>(draw.below(1U << 30)) + 0.5) / (1U << 30); }
double exponential(BoundedDraw& draw) { return -std::log(uniform(draw)); }

constexpr int kSimulations = 400;

/// Successes of a 95 % interval over 400 samples: binomial(400, 0.95) leaves 361 .. 397 with probability below 1e-4 at
/// either side; the percentile bootstrap is known to cover a little less at n = 60, hence 355 at the lower end.
void expect_coverage(int covered) {
  EXPECT_GE(covered, 355);
  EXPECT_LE(covered, 397);
}

TEST(StatisticsTest, MedianIntervalCoversTheTrueMedian) {
  BoundedDraw draw(2);
  int covered = 0;
  for (int simulation = 0; simulation < kSimulations; ++simulation) {
    std::vector<double> sample(60);
    for (double& value : sample) value = exponential(draw);
    const Estimate estimate = median_estimate(sample);
    if (estimate.low <= std::log(2.0) && std::log(2.0) <= estimate.high) ++covered;
  }
  expect_coverage(covered);
}

/// Pairs share a factor (the problem's difficulty), as times of two solvers on one problem do.
TEST(StatisticsTest, RatioIntervalCoversTheTrueRatioOfPairs) {
  BoundedDraw draw(3);
  int covered = 0;
  for (int simulation = 0; simulation < kSimulations; ++simulation) {
    std::vector<double> reference(60);
    std::vector<double> solver(60);
    for (std::size_t i = 0; i < solver.size(); ++i) {
      const double difficulty = exponential(draw);
      reference[i] = 6 * difficulty * (0.5 + uniform(draw));
      solver[i] = 2 * difficulty * (0.5 + uniform(draw));
    }
    const Estimate estimate = ratio_of_sums(reference, solver);
    if (estimate.low <= 3 && 3 <= estimate.high) ++covered;
  }
  expect_coverage(covered);
}

TEST(StatisticsTest, WilsonIntervalCoversTheTrueShare) {
  BoundedDraw draw(4);
  int covered = 0;
  for (int simulation = 0; simulation < kSimulations; ++simulation) {
    std::int64_t successes = 0;
    for (int i = 0; i < 100; ++i) successes += uniform(draw) < 0.3 ? 1 : 0;
    const Interval interval = wilson(successes, 100);
    if (interval.low <= 0.3 && 0.3 <= interval.high) ++covered;
  }
  expect_coverage(covered);
}

TEST(StatisticsTest, RatioOfProportionalTimesIsExactAndItsIntervalIsAPoint) {
  const std::vector<double> solver{1, 2, 4, 8};
  const std::vector<double> reference{3, 6, 12, 24};
  const Estimate estimate = ratio_of_sums(reference, solver);
  EXPECT_EQ(estimate.value, 3);
  EXPECT_EQ(estimate.low, 3);
  EXPECT_EQ(estimate.high, 3);
}

TEST(StatisticsTest, RatioWithoutTimesIsNotANumber) {
  EXPECT_TRUE(std::isnan(ratio_of_sums({}, {}).value));
  const std::vector<double> zeros{0, 0};
  const std::vector<double> ones{1, 1};
  EXPECT_TRUE(std::isnan(ratio_of_sums(ones, zeros).value));
  EXPECT_THROW(ratio_of_sums(ones, {}), std::invalid_argument);
}

TEST(StatisticsTest, BootstrapsOfASingleValueHaveNoInterval) {
  const std::vector<double> one{2};
  const std::vector<double> other{6};
  for (const Estimate& estimate : {median_estimate(one), ratio_of_sums(one, other)}) {
    EXPECT_TRUE(std::isfinite(estimate.value));
    EXPECT_TRUE(std::isnan(estimate.low));
    EXPECT_TRUE(std::isnan(estimate.high));
  }
}

/// From the least to the largest of n values is an interval of 1 - 2^(1 - n).
TEST(StatisticsTest, MediansOfFewerThanSixValuesHaveNoInterval) {
  std::vector<double> values{1, 2, 3};
  for (; values.size() < 6; values.push_back(4)) EXPECT_TRUE(std::isnan(median_estimate(values).low)) << values.size();
  EXPECT_EQ(median_estimate(values).low, 1);
  EXPECT_EQ(median_estimate(values).high, 4);
}

TEST(StatisticsTest, BootstrapsRepeatToTheLastBit) {
  const std::vector<double> values{3, 1, 4, 1, 5, 9, 2, 6};
  EXPECT_EQ(median_estimate(values).low, median_estimate(values).low);
  const Estimate median = median_estimate(values);
  EXPECT_EQ(median.value, 3.5);
  EXPECT_LE(median.low, median.value);
  EXPECT_GE(median.high, median.value);
  EXPECT_TRUE(std::isnan(median_estimate({}).value));
}

TEST(StatisticsTest, TiesInTimeAreCloseToOneOrUnsure) {
  EXPECT_TRUE(is_tie_in_time({1.04, 1.03, 1.05}));
  EXPECT_TRUE(is_tie_in_time({0.96, 0.95, 0.97}));
  EXPECT_TRUE(is_tie_in_time({2, 0.9, 4}));
  EXPECT_FALSE(is_tie_in_time({1.06, 1.01, 1.1}));
  EXPECT_FALSE(is_tie_in_time({0.94, 0.9, 0.99}));
  EXPECT_FALSE(is_tie_in_time({std::nan(""), std::nan(""), std::nan("")}));
}

TEST(StatisticsTest, McNemarCountsCoins) {
  EXPECT_EQ(mcnemar_exact(0, 0), 1);
  EXPECT_DOUBLE_EQ(mcnemar_exact(0, 5), 2.0 / 32);
  EXPECT_DOUBLE_EQ(mcnemar_exact(1, 7), 2.0 * 9 / 256);
  EXPECT_EQ(mcnemar_exact(3, 3), 1);
  EXPECT_EQ(mcnemar_exact(7, 1), mcnemar_exact(1, 7));
  EXPECT_LT(mcnemar_exact(0, 5000), 1e-300);
}

/// The two examples of Fagerland, Lydersen and Laake (BMC Medical Research Methodology 13:91, 2013), who print 0.070
/// and 0.052 for the exact conditional test.
TEST(StatisticsTest, McNemarMatchesFagerlandsExamples) {
  EXPECT_DOUBLE_EQ(mcnemar_exact(1, 7), 18.0 / 256);
  EXPECT_NEAR(mcnemar_exact(1, 7), 0.070, 5e-4);
  EXPECT_NEAR(mcnemar_exact(6, 16), 2 * 110056.0 / 4194304, 1e-14);
  EXPECT_NEAR(mcnemar_exact(6, 16), 0.052, 5e-4);
  EXPECT_EQ(mcnemar_exact(0, 0), 1);
  EXPECT_THROW(mcnemar_exact(-1, 3), std::invalid_argument);
}

/// The exact test may be conservative, never liberal: under equal solvers the chance of p <= 0.05, summed over all
/// outcomes, stays at most 0.05 for every number of discordant problems.
TEST(StatisticsTest, McNemarKeepsItsLevelExactly) {
  for (const std::int64_t discordant : {1, 5, 6, 17, 100, 1001}) {
    double rejected = 0;
    for (std::int64_t first = 0; first <= discordant; ++first) {
      const auto n = static_cast<double>(discordant);
      const auto k = static_cast<double>(first);
      if (mcnemar_exact(first, discordant - first) > 0.05) continue;
      rejected += std::exp(std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1) - n * std::log(2.0));
    }
    EXPECT_LE(rejected, 0.05 + 1e-12) << discordant;
    if (discordant > 100) {
      EXPECT_GT(rejected, 0.03) << discordant;
    }
  }
}

/// Newcombe 1998, Statistics in Medicine 17:873, Table II, method 10: 56/70 against 48/80 and others.
TEST(StatisticsTest, DifferencesOfSharesHaveNewcombesInterval) {
  const auto check = [](double a, double m, double b, double n, double low, double high) {
    const Estimate difference = combination_of_shares(std::vector<double>{1, a / m, m, -1, b / n, n});
    EXPECT_NEAR(difference.low, low, 5e-5);
    EXPECT_NEAR(difference.high, high, 5e-5);
  };
  check(56, 70, 48, 80, 0.0524, 0.3339);
  check(9, 10, 3, 10, 0.1705, 0.8090);
  check(10, 10, 0, 20, 0.6791, 1.0);
  check(0, 10, 0, 20, -0.1611, 0.2775);
  EXPECT_TRUE(std::isnan(wilson_of_share(0, 0).low));
}

TEST(StatisticsTest, NormalQuantilesAreThoseOfTheTables) {
  EXPECT_NEAR(normal_quantile(0.05), 1.959963984540054, 1e-12);
  EXPECT_NEAR(normal_quantile(0.01), 2.5758293035489, 1e-11);
}

TEST(LogSumsTest, GeometricMeanAndItsInterval) {
  LogSums sums;
  for (const double value : {1.0, 4.0, 16.0}) sums.add(std::log(value));
  EXPECT_NEAR(sums.geometric_mean().value, 4, 1e-12);
  EXPECT_NEAR(sums.geometric_mean().high, 4 * std::exp(1.959963984540054 * std::log(4.0) / std::sqrt(3.0)), 1e-9);
}

}  // namespace
}  // namespace lcpbench::statistics_test
