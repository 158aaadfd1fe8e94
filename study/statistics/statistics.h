#pragma once

#include <cstdint>
#include <limits>
#include <random>
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

/// Whole numbers below a bound from a 64-bit Mersenne Twister, whose output the C++ standard fixes, by Lemire's
/// unbiased multiply-shift (2019): the same draws on every platform, which std::uniform_int_distribution does not
/// promise.
class BoundedDraw {
 public:
  explicit BoundedDraw(std::uint64_t seed) : engine_(seed) {}
  /// Uniform in 0 .. bound - 1. @pre bound > 0.
  std::uint64_t below(std::uint64_t bound);

 private:
  std::mt19937_64 engine_;
};

/// Quantiles of the normal distribution: two-sided 95 % and 99.9 %.
inline constexpr double kNormal975 = 1.959963984540054;
inline constexpr double kNormal9995 = 3.2905267314919255;

/// Wilson's score interval for a share (Wilson 1927), without continuity correction; NaN for no trials.
/// Coverage averages the level and dips below it near 0 and 1, never to 0 as the normal approximation does.
/// @param quantile  of the normal distribution: the level, 95 % unless told.
/// @throws std::invalid_argument unless 0 <= successes <= trials.
Interval wilson(std::int64_t successes, std::int64_t trials, double quantile = kNormal975);

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

/// p-values corrected for their number by Holm's step-down procedure (1979): rejecting those at most alpha keeps the
/// chance of even one false rejection at most alpha, whatever the dependence between the tests. In the order given. A
/// NaN is no test: it stays NaN and does not count. O(n log n).
std::vector<double> holm(std::span<const double> p_values);

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
