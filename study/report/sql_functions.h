#pragma once

#include "study/store/sqlite.h"

namespace lcpbench::report {

/// Gives the queries of a connection the statistics of study/statistics. NULL in, NULL out; NULL where there is none.
///
///   wilson_low(part, whole), wilson_high(part, whole)   95 % interval of a share
///   difference_low(a, of_a, b, of_b), difference_high   95 % interval of a - b, shares of independent trials
///   estimate(form, terms), estimate_low(form, terms, level), estimate_high   a quantity of study/paper/claims.sql and
///                                                       its interval, which misses it with the chance `level`
///   estimate_p(form, terms)                             the exact p-value of pairs
///   mcnemar(only_a, only_b)                             exact two-sided p-value
///   quantile(x, share), median(x)                       aggregates; NULL is left out, infinity is not
///   sigma(x)                                            sample standard deviation, aggregate
///   median_low(x), median_high(x)                       95 % interval of the median, aggregates
///   geometric_mean(x), geometric_mean_low(x), geometric_mean_high(x)   with a 95 % interval, normal on the logarithms
void add_statistics_functions(sqlite::Database& database);

}  // namespace lcpbench::report
