#pragma once

#include "study/store/sqlite.h"

namespace lcpbench::report {

/// Makes the statistics of study/statistics functions of a connection's SQL. A function of one row gives NULL if an
/// argument is NULL; every function gives NULL if the data give no value.
///
///   wilson_low(part, whole), wilson_high(part, whole)   95 % interval of the share part / whole, both counts
///   difference_low(share_a, trials_a, share_b, trials_b), difference_high   95 % interval of share_a - share_b, from
///                                                       independent trials
///   estimate(form, terms), estimate_low(form, terms, level), estimate_high   a quantity as study/paper/claims.sql
///                                                       writes it, and its interval of confidence 1 - level
///   estimate_p(form, terms)                             exact p-value (McNemar) of "pairs", NULL for other forms
///   mcnemar(only_a, only_b)                             exact two-sided p-value
///   quantile(x, share), sigma(x)                        aggregates: quantile and sample standard deviation. An x of
///                                                       NULL is left out, infinity is not; a share outside of (0, 1]
///                                                       is an error
///   median(x), median_low(x), median_high(x)            aggregates: the median and its 95 % interval; NULL as above
///   log_mean_low(n, sum, square_sum), log_mean_high     95 % interval of a geometric mean, from sums of logarithms
///   percent(x), percent_range(low, high), duration(s), factor(x), scientific(x)   as text, see text.h
///   spec_name(text), spec_option(text, key)             of a set or solver, "name{key=value}": its name, and the value
///                                                       that the text gives to an option; defaults are not known
///   solver_setting(text, key)                           the numeric setting of a solver or, if it has none of this
///                                                       name, of the solver that it wraps; defaults are known
void add_statistics_functions(sqlite::Database& database);

}  // namespace lcpbench::report
