#pragma once

#include <cstdint>
#include <limits>
#include <span>

namespace lcpbench {

inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();  // where the data give no number
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A closed range. Both ends are NaN if there is no interval.
struct Interval {
  double low = 0;
  double high = 0;
};

/// A number with its 95 % interval. A member is NaN if the data do not give it.
struct Estimate {
  double value = 0;
  double low = 0;
  double high = 0;
};

/// Mean, sample standard deviation (divisor n - 1; NaN for n < 2), largest value and median; all NaN for no values.
struct Spread {
  std::int64_t count = 0;
  double mean = 0;
  double sigma = 0;
  double max = 0;
  double median = 0;
};

/// Quantiles of the normal distribution: two-sided 95 % and 99.9 %.
inline constexpr double kNormal975 = 1.959963984540054;
inline constexpr double kNormal9995 = 3.2905267314919255;

/// Wilson's score interval for a share (Wilson 1927), without continuity correction; NaN for no trials.
/// Its coverage is the level on average. Near the shares 0 and 1 it can be less, but it never falls to 0, unlike
/// that of the normal approximation.
/// @param quantile  of the standard normal distribution; it sets the level of the interval
/// @throws std::invalid_argument unless 0 <= successes <= trials.
Interval wilson(std::int64_t successes, std::int64_t trials, double quantile = kNormal975);

/// The same for a share that need not be that of a whole count: it may be the mean over parameterisations that met the
/// same problems. The variance of the mean of numbers in [0, 1] is at most that of a share of the same size, so its
/// interval as a share is not too narrow however the parameterisations depend on each other. NaN for no trials.
Interval wilson_of_share(double share, double trials, double quantile = kNormal975);

/// The two-sided normal quantile: a standard normal variable exceeds it in size with probability alpha in (0, 1).
double normal_quantile(double alpha);

/// A linear combination of shares of trials, by the method of variance estimates recovery on Wilson intervals (Newcombe
/// 1998, method 10, for a difference; Zou, Huang and Zhang 2009 in general). It takes the shares as independent. Shares
/// of the same problems, which agree more often than chance, make the interval of their difference wider than need be;
/// terms of one sign that agree make that of their sum too narrow, at most by the square root of their number.
/// @param terms  coefficient, share and trials of each
Estimate combination_of_shares(std::span<const double> terms, double quantile = kNormal975);

/// The ratio of two means of independent samples, normal on the scale of its logarithm (the delta method); NaN unless
/// both means are positive and both counts above 1. @param terms  mean, sigma and count of the numerator, then those of
/// the denominator
Estimate ratio_of_means(std::span<const double, 6> terms, double quantile = kNormal975);

/// The difference of the shares that two solvers solved of the same problems, of which each solved some that the other
/// did not. Wald's interval with half a problem added to each of the four counts (Agresti and Min 2005).
Estimate paired_difference(double problems, double only_first, double only_second, double quantile = kNormal975);

/// The smallest of the values that at least the share p of them do not exceed (the inverse of the empirical
/// distribution, type 1 of Hyndman and Fan 1996): always a value that occurred, infinity included. NaN for no values.
/// @param sorted  ascending, no NaN
/// @param p       in (0, 1]
double quantile(std::span<const double> sorted, double p);

/// The middle value, or the mean of the two middle values. NaN for no values. @param sorted  ascending, no NaN
double median(std::span<const double> sorted);

/// @param values in any order, no NaN
Spread spread(std::span<const double> values);
/// @param sorted  ascending, no NaN
Spread spread_of_sorted(std::span<const double> sorted);

/// Median with its 95 % interval, for any distribution of the values. The ends of the interval are two of the values
/// (David and Nagaraja 2003, section 7.1). The normal approximation of the binomial distribution gives their ranks.
/// Fewer than six values have no interval: from the least to the largest of five covers 94 %. O(n log n).
/// @param values in any order, no NaN
Estimate median_estimate(std::span<const double> values);

/// sum(numerator) / sum(denominator), the times of two solvers on the same problems. The 95 % interval takes the
/// problems as a sample and the logarithm of the ratio as normal (the delta method). NaN for no pairs, and if a sum is
/// not positive. One pair has no interval.
/// @throws std::invalid_argument when the lengths differ.
Estimate ratio_of_sums(std::span<const double> numerator, std::span<const double> denominator);

/// Two runs of the same solver may differ by 5 % in time. A smaller difference between two solvers means nothing.
inline constexpr double kTieInTime = 1.05;

/// Whether a ratio of times cannot be distinguished from 1: it is within 5 % of 1, or its interval contains 1. False
/// for NaN.
bool is_tie_in_time(const Estimate& ratio);

/// p-value of the exact two-sided McNemar test (McNemar 1947, with the binomial distribution and not its normal
/// approximation). Discordant problems are those that exactly one of two solvers solves; the others do not count. The
/// value is the probability of counts at least as unequal, if both solvers are equally good. It is 1 for no discordant
/// problems. The test never exceeds its level, and has less power if few problems are discordant.
/// @throws std::invalid_argument for negative counts.
double mcnemar_exact(std::int64_t only_first, std::int64_t only_second);

/// Sums over logarithms: of times [s], or of ratios of times.
struct LogSums {
  std::int64_t n = 0;
  double sum = 0;
  double square_sum = 0;

  void add(double logarithm);
  LogSums& operator+=(const LogSums& other);
  bool operator==(const LogSums&) const = default;
  /// The geometric mean. Its 95 % interval takes the mean of the logarithms as normal: with fewer than some 50 values
  /// the coverage is below 95 %. No interval for n < 2. NaN for no values.
  Estimate geometric_mean() const;
};

}  // namespace lcpbench
