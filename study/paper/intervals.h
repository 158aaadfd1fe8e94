#pragma once

#include <vector>

#include "study/statistics/pairs.h"

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
  /// Huang and Zhang 2009 in general). It takes the shares as independent. Shares of the same problems, which agree
  /// more often than chance, make the interval of their difference wider than need be; terms of one sign that agree
  /// make that of their sum too narrow, at most by the square root of the number of such terms.
  Interval interval(double z = kZ95) const;
};

/// first - second
LinearCombination difference(const Proportion& first, const Proportion& second);

/// Pooled values of parameterisations that met the same problems. Values of one problem depend on each other, so the
/// pooled count says nothing of how well the mean is known; the problems do.
struct PooledMean {
  Spread values{};
  /// Pooled values per parameterisation that has any. The sum of a problem's deviations over at most c
  /// parameterisations has a square of at most c times the sum of their squares (Cauchy and Schwarz), so the variance
  /// of the pooled mean is at most sigma^2 / (count / c), however the values of a problem depend on each other.
  double problems = 0;
};

/// mean / mean, with the interval of its logarithm by the delta method on the counts of problems, the two means taken
/// as independent; NaN unless both means are positive and both counts above 1.
struct RatioOfMeans {
  PooledMean numerator{};
  PooledMean denominator{};

  double value() const;
  Interval interval(double z = kZ95) const;
};

/// One group of values from the counts, means, deviations and maxima of its parts, exactly (within + between); the
/// median, which parts do not give, is NaN.
Spread pooled(const std::vector<Spread>& parts);

/// The same with the number of problems behind it. @param parts one for each parameterisation
PooledMean pooled_mean(const std::vector<Spread>& parts);

/// The shares that two solvers solved of the same problems.
struct PairedShares : PairedCounts {
  /// Share of the first less that of the second.
  double value() const;
  /// Of the difference: Wald's with half a problem added to each count (Agresti and Min 2005).
  Interval interval(double z = kZ95) const;
};

}  // namespace lcpbench::paper
