#include "study/report/sql_functions.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <sqlite3.h>

#include "study/paper/intervals.h"
#include "study/statistics/statistics.h"

namespace lcpbench::report {
namespace {

constexpr int kFlags = SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_INNOCUOUS;

void give(sqlite3_context* context, double value) {
  std::isnan(value) ? sqlite3_result_null(context) : sqlite3_result_double(context, value);
}

/// SQLite is C: no exception may pass it.
template <class Work>
void guarded(sqlite3_context* context, Work work) {
  try {
    work();
  } catch (const std::bad_alloc&) {
    sqlite3_result_error_nomem(context);
  } catch (const std::exception& error) {
    sqlite3_result_error(context, error.what(), -1);
  }
}

/// A function of two counts.
template <auto function>
void call(sqlite3_context* context, int, sqlite3_value** arguments) {
  for (int i = 0; i < 2; ++i) {
    if (sqlite3_value_type(arguments[i]) == SQLITE_NULL) return sqlite3_result_null(context);
  }
  guarded(context, [&] {
    give(context, function(sqlite3_value_int64(arguments[0]), sqlite3_value_int64(arguments[1])));
  });
}

/// The values of a group, and the second argument of its last row.
struct Sample {
  std::vector<double> values;
  double argument = 0;
};

void collect(sqlite3_context* context, int count, sqlite3_value** arguments) {
  auto** slot = static_cast<Sample**>(sqlite3_aggregate_context(context, sizeof(Sample*)));
  if (slot == nullptr) return sqlite3_result_error_nomem(context);
  guarded(context, [&] {
    if (*slot == nullptr) *slot = new Sample;
    if (count > 1) (*slot)->argument = sqlite3_value_double(arguments[1]);
    if (sqlite3_value_type(arguments[0]) == SQLITE_NULL) return;
    (*slot)->values.push_back(sqlite3_value_double(arguments[0]));
  });
}

template <auto function>
void finish(sqlite3_context* context) {
  auto** slot = static_cast<Sample**>(sqlite3_aggregate_context(context, 0));
  if (slot == nullptr || *slot == nullptr) return sqlite3_result_null(context);
  guarded(context, [&] { give(context, function(**slot)); });
  delete *slot;
  *slot = nullptr;
}

double low_of_wilson(std::int64_t part, std::int64_t whole) { return wilson(part, whole).low; }
double high_of_wilson(std::int64_t part, std::int64_t whole) { return wilson(part, whole).high; }

double quantile_of(Sample& sample) {
  if (!(sample.argument > 0 && sample.argument <= 1)) throw std::invalid_argument("quantile: the share is not in (0, 1]");
  std::sort(sample.values.begin(), sample.values.end());
  return quantile(sample.values, sample.argument);
}

double median_of(Sample& sample) {
  std::sort(sample.values.begin(), sample.values.end());
  return median(sample.values);
}

Estimate geometric_mean(const Sample& sample) {
  LogSums sums;
  for (const double value : sample.values) sums.add(std::log(value));
  return sums.geometric_mean();
}

/// An end of the interval of share_a - share_b, two shares of independent trials.
template <double Interval::*end>
void difference(sqlite3_context* context, int, sqlite3_value** arguments) {
  for (int i = 0; i < 4; ++i) {
    if (sqlite3_value_type(arguments[i]) == SQLITE_NULL) return sqlite3_result_null(context);
  }
  guarded(context, [&] {
    const auto share = [arguments](int i) {
      const double of = sqlite3_value_double(arguments[i + 1]);
      return paper::Proportion{sqlite3_value_double(arguments[i]) * of, of};
    };
    give(context, paper::difference(share(0), share(2)).interval().*end);
  });
}

/// The numbers of a text, by blanks.
std::vector<double> numbers_of(const char* text) {
  std::vector<double> numbers;
  for (char* end = nullptr;; text = end) {
    const double number = std::strtod(text, &end);
    if (end == text) return numbers;
    numbers.push_back(number);
  }
}

/// A quantity of study/paper/claims.sql: its value with the interval at the normal quantile z. Else NaN.
Estimate estimate(const std::string& form, const std::vector<double>& terms, double z) {
  const auto with = [z](const auto& quantity) {
    const Interval interval = quantity.interval(z);
    return Estimate{quantity.value(), interval.low, interval.high};
  };
  if (form == "number" && terms.size() == 1) return {terms[0], kNoNumber, kNoNumber};
  if (form == "pairs" && terms.size() == 3) return with(paper::PairedShares{terms[0], terms[1], terms[2]});
  if (form == "means" && terms.size() == 6) {
    return with(paper::RatioOfMeans{{terms[0], terms[1], terms[2]}, {terms[3], terms[4], terms[5]}});
  }
  if (form != "shares" || terms.empty() || terms.size() % 3 != 0) throw std::invalid_argument("estimate: unknown form");
  paper::LinearCombination shares;
  for (std::size_t i = 0; i < terms.size(); i += 3) {
    shares.terms.push_back({terms[i], {terms[i + 1] * terms[i + 2], terms[i + 2]}});
  }
  return with(shares);
}

template <double Estimate::*part>
void call_estimate(sqlite3_context* context, int count, sqlite3_value** arguments) {
  for (int i = 0; i < count; ++i) {
    if (sqlite3_value_type(arguments[i]) == SQLITE_NULL) return sqlite3_result_null(context);
  }
  guarded(context, [&] {
    const auto text = [arguments](int i) { return reinterpret_cast<const char*>(sqlite3_value_text(arguments[i])); };
    const double z = count > 2 ? paper::normal_quantile(sqlite3_value_double(arguments[2])) : kNormal975;
    give(context, estimate(text(0), numbers_of(text(1)), z).*part);
  });
}

/// Of an exact test that has to agree with the interval; none but for pairs.
void call_p(sqlite3_context* context, int, sqlite3_value** arguments) {
  guarded(context, [&] {
    const auto text = [arguments](int i) { return reinterpret_cast<const char*>(sqlite3_value_text(arguments[i])); };
    if (std::string_view(text(0)) != "pairs") return sqlite3_result_null(context);
    const std::vector<double> terms = numbers_of(text(1));
    give(context, mcnemar_exact(static_cast<std::int64_t>(terms.at(1)), static_cast<std::int64_t>(terms.at(2))));
  });
}

using Function = void (*)(sqlite3_context*, int, sqlite3_value**);
void add(sqlite::Database& database, const char* name, int arguments, Function function) {
  const int code = sqlite3_create_function_v2(database.handle(), name, arguments, kFlags, nullptr, function, nullptr,
                                              nullptr, nullptr);
  if (code != SQLITE_OK) database.fail(code);
}

template <auto function>
void add_aggregate(sqlite::Database& database, const char* name, int arguments = 1) {
  const int code = sqlite3_create_function_v2(database.handle(), name, arguments, kFlags, nullptr, nullptr, collect,
                                              finish<function>, nullptr);
  if (code != SQLITE_OK) database.fail(code);
}

}  // namespace

void add_statistics_functions(sqlite::Database& database) {
  add(database, "wilson_low", 2, call<low_of_wilson>);
  add(database, "wilson_high", 2, call<high_of_wilson>);
  add(database, "mcnemar", 2, call<mcnemar_exact>);
  add(database, "difference_low", 4, difference<&Interval::low>);
  add(database, "difference_high", 4, difference<&Interval::high>);
  add(database, "estimate", 2, call_estimate<&Estimate::value>);
  add(database, "estimate_low", 3, call_estimate<&Estimate::low>);
  add(database, "estimate_high", 3, call_estimate<&Estimate::high>);
  add(database, "estimate_p", 2, call_p);
  add_aggregate<quantile_of>(database, "quantile", 2);
  add_aggregate<median_of>(database, "median");
  add_aggregate<[](Sample& s) { return spread(s.values).sigma; }>(database, "sigma");
  add_aggregate<[](Sample& s) { return median_estimate(s.values).low; }>(database, "median_low");
  add_aggregate<[](Sample& s) { return median_estimate(s.values).high; }>(database, "median_high");
  add_aggregate<[](Sample& s) { return geometric_mean(s).value; }>(database, "geometric_mean");
  add_aggregate<[](Sample& s) { return geometric_mean(s).low; }>(database, "geometric_mean_low");
  add_aggregate<[](Sample& s) { return geometric_mean(s).high; }>(database, "geometric_mean_high");
}

}  // namespace lcpbench::report
