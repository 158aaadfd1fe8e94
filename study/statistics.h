#pragma once

#include <cstdint>
#include <random>
#include <span>

namespace lcpbench {

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

/// Resamples drawn by every bootstrap here. Their noise moves an end of an interval by about 1/10 of its half-width.
inline constexpr int kResamples = 1000;

/// Wilson's 95 % score interval for a share (Wilson 1927), without continuity correction; NaN for no trials.
/// Coverage averages 95 % and dips below it near 0 and 1, never to 0 as the normal approximation does.
/// @throws std::invalid_argument unless 0 <= successes <= trials.
Interval wilson(std::int64_t successes, std::int64_t trials);

/// The smallest of the values that at least the share p of them do not exceed (the inverse of the empirical
/// distribution, type 1 of Hyndman and Fan 1996): always a value that occurred, infinity included. NaN for no values.
/// @param sorted  ascending, no NaN
/// @param p       in (0, 1]
double quantile(std::span<const double> sorted, double p);

/// The middle value, or the mean of the two middle ones. NaN for no values. @param sorted ascending, no NaN
double median(std::span<const double> sorted);

/// @param values in any order, no NaN
Spread spread(std::span<const double> values);

/// Median with its percentile-bootstrap interval; O(kResamples n). The same values give the same interval.
/// @param values in any order, no NaN
Estimate median_estimate(std::span<const double> values);

/// sum(reference) / sum(solver), two times of the same problems, with its percentile-bootstrap interval over problems:
/// the speed-up of `solver`. Resampling keeps each pair together. NaN for no pairs or a sum that is not positive.
/// @throws std::invalid_argument when the lengths differ.
Estimate ratio_of_sums(std::span<const double> reference, std::span<const double> solver);

/// Two-sided exact sign test: the chance that a fair coin splits first + second tosses at least this unevenly. With the
/// counts of problems that only one of two solvers solved it is McNemar's exact test. 1 for no tosses.
double sign_test(std::int64_t first, std::int64_t second);

}  // namespace lcpbench
