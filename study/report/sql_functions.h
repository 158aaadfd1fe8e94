#pragma once

#include "study/store/sqlite.h"

namespace lcpbench::report {

/// Gives the queries of a connection the statistics of study/statistics. NULL in, NULL out; NULL where there is none.
///
///   wilson_low(part, whole), wilson_high(part, whole)   95 % interval of a share
///   difference_low(a, of_a, b, of_b), difference_high   95 % interval of a - b, shares of independent trials
///   estimate(form, terms), estimate_low(form, terms, level), estimate_high   a quantity of study/paper/claims.sql and
///                                                       its interval, which misses it with the chance `level`
///   estimate_p(form, terms)                             the exact p-value of pairs, NULL for other forms
///   mcnemar(only_a, only_b)                             exact two-sided p-value
///   quantile(x, share), sigma(x)                        aggregates; an x of NULL is left out, infinity is not;
///                                                       a share outside of (0, 1] is an error
///   median(x), median_low(x), median_high(x)            aggregates: the median and its 95 % interval
///   log_mean_low(n, sum, square_sum), log_mean_high     that of a geometric mean, from sums of logarithms
///   percent(x), percent_range(low, high), duration(s), factor(x), scientific(x)   as text, see text.h
///   spec_name(text), spec_option(text, key)             of a set or solver, "name{key=value}"
///   solver_setting(text, key)                           the number that a solver, or the one that it wraps, has there
void add_statistics_functions(sqlite::Database& database);

}  // namespace lcpbench::report
