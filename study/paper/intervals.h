#pragma once

#include <vector>

#include "study/statistics.h"

namespace lcpbench::paper {

/// 95 % two-sided.
inline constexpr double kZ95 = 1.959963984540054;

/// The two-sided normal quantile: a standard normal variable exceeds it in size with probability alpha in (0, 1).
double normal_quantile(double alpha);

/// A share of trials. `successes` need not be whole: it may be the mean over parameterisations that met the same
/// problems. The variance of the mean of numbers in [0, 1] is at most that of a share of the same size, so its interval
/// as a share is not too narrow however the parameterisations depend on each other.
struct Proportion {
  double successes = 0;
  double trials = 0;

  /// NaN for no trials.
  double value() const;
  /// Wilson's score interval at normal quantile z; NaN for no trials.
  Interval interval(double z = kZ95) const;
};

/// One summand of a linear combination of shares.
struct Term {
  double coefficient = 1;
  Proportion share;
};

/// A linear combination of shares, such as a difference, or a difference of differences.
struct LinearCombination {
  std::vector<Term> terms;

  double value() const;
  /// The method of variance estimates recovery on Wilson intervals (Newcombe 1998, method 10, for a difference; Zou,
  /// Huang and Zhang 2009 in general). It takes the shares as independent: for shares of the same problems, which agree
  /// more often than chance, it is wider than need be, never narrower.
  Interval interval(double z = kZ95) const;
};

/// first - second
LinearCombination difference(const Proportion& first, const Proportion& second);

/// mean / mean, with the interval of its logarithm by the delta method, the two taken as independent; NaN unless both
/// means are positive and both counts above 1.
struct RatioOfMeans {
  Spread numerator{};
  Spread denominator{};

  double value() const;
  Interval interval(double z = kZ95) const;
};

/// One group of values from the counts, means, deviations and maxima of its parts, exactly (within + between); the
/// median, which parts do not give, is NaN.
Spread pooled(const std::vector<Spread>& parts);

/// Two solvers, or one on two sets with the same problems, paired by problem.
struct PairedCounts {
  std::int64_t both = 0;
  std::int64_t first_only = 0;
  std::int64_t second_only = 0;
  std::int64_t neither = 0;

  std::int64_t problems() const { return both + first_only + second_only + neither; }
  /// Share of the first less that of the second.
  double difference() const;
  /// Of the difference: Wald's with half a problem added to each count (Agresti and Min 2005).
  Interval interval(double z = kZ95) const;
  /// McNemar's exact test.
  double p_value() const { return mcnemar_exact(first_only, second_only); }
};

}  // namespace lcpbench::paper
