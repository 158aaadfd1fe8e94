#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace lcpbench {

inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();  // where the data give no number
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A closed range; both ends NaN where none can be given.
struct Interval {
  double low = 0;
  double high = 0;
};

/// A number with its 95 % interval; NaN where the data give none.
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
/// Coverage averages the level and dips below it near 0 and 1, never to 0 as the normal approximation does.
/// @param quantile  of the normal distribution: the level, 95 % unless told.
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

/// Difference of the shares that two solvers solved of the same problems, each alone so many: Wald's interval with half
/// a problem added to each count (Agresti and Min 2005).
Estimate paired_difference(double problems, double only_first, double only_second, double quantile = kNormal975);

/// The smallest of the values that at least the share p of them do not exceed (the inverse of the empirical
/// distribution, type 1 of Hyndman and Fan 1996): always a value that occurred, infinity included. NaN for no values.
/// @param sorted  ascending, no NaN
/// @param p       in (0, 1]
double quantile(std::span<const double> sorted, double p);

/// The middle value, or the mean of the two middle ones. NaN for no values. @param sorted ascending, no NaN
double median(std::span<const double> sorted);

/// @param values in any order, no NaN
Spread spread(std::span<const double> values);
/// @param sorted  ascending, no NaN
Spread spread_of_sorted(std::span<const double> sorted);

/// Median with its 95 % interval between two of the values (David and Nagaraja 2003, section 7.1), whatever their
/// distribution; their ranks by the normal limit of the binomial. A single value has none, of two to five the interval
/// reaches from the least to the largest and covers less. O(n log n).
/// @param values in any order, no NaN
Estimate median_estimate(std::span<const double> values);

/// sum(reference) / sum(solver), two times of the same problems, with its 95 % interval over problems, normal on the
/// scale of its logarithm (the delta method): the speed-up of `solver`. NaN for no pairs or a sum that is not positive; a
/// single pair has no interval.
/// @throws std::invalid_argument when the lengths differ.
Estimate ratio_of_sums(std::span<const double> reference, std::span<const double> solver);

/// Differences in time under 5 % are within what two equal runs show.
inline constexpr double kTieInTime = 1.05;

/// Is a ratio of times not to be told from 1: within 5 % of it, or with an interval that contains it? False for NaN.
bool is_tie_in_time(const Estimate& ratio);

/// Exact two-sided McNemar test (McNemar 1947, with the binomial instead of its normal limit): the chance of an outcome
/// at least this lopsided among problems that exactly one of two equally good solvers solves. Concordant problems carry
/// no evidence on the difference. Never above its level; the price is some power when few problems are discordant. 1
/// for no discordant problems.
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
  /// The geometric mean with its 95 % interval, normal on the scale of the logarithms: needs some 50 values, for fewer
  /// it covers less than it says. No interval for n < 2, NaN for none.
  Estimate geometric_mean() const;
};

}  // namespace lcpbench
