#pragma once

#include <vector>

#include "study/statistics/statistics.h"

namespace lcpbench::paper {

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
  Interval interval(double z = kNormal975) const;
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
  Interval interval(double z = kNormal975) const;
};

/// first - second
LinearCombination difference(const Proportion& first, const Proportion& second);

/// The mean of a quantity over problems.
struct Mean {
  double mean = kNoNumber;
  double sigma = kNoNumber;  ///< of the values
  double problems = 0;
};

/// mean / mean, with the interval of its logarithm by the delta method on the counts of problems, the two means taken
/// as independent; NaN unless both means are positive and both counts above 1.
struct RatioOfMeans {
  Mean numerator;
  Mean denominator;

  double value() const;
  Interval interval(double z = kNormal975) const;
};

/// The shares that two solvers solved of the same problems.
struct PairedShares {
  double problems = 0;
  double only_first = 0;  ///< problems that the first solved alone
  double only_second = 0;

  /// Share of the first less that of the second.
  double value() const;
  /// Of the difference: Wald's with half a problem added to each count (Agresti and Min 2005).
  Interval interval(double z = kNormal975) const;
};

}  // namespace lcpbench::paper
