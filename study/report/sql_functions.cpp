#include "study/report/sql_functions.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <iterator>
#include <optional>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <sqlite3.h>

#include "core/error.h"
#include "core/registry.h"
#include "study/report/sets.h"
#include "study/report/text.h"
#include "study/statistics/statistics.h"

namespace lcpbench::report {
namespace {

constexpr int kFlags = SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_INNOCUOUS;

void give(sqlite3_context* context, double value) {
  std::isnan(value) ? sqlite3_result_null(context) : sqlite3_result_double(context, value);
}

void give(sqlite3_context* context, const std::optional<std::string>& text) {
  if (!text) return sqlite3_result_null(context);
  sqlite3_result_text(context, text->data(), static_cast<int>(text->size()), SQLITE_TRANSIENT);
}

/// Makes an exception the SQL error of the call: it must not pass through SQLite, which is C.
template <class Work>
void guarded(sqlite3_context* context, Work work) {
  try {
    work();
  } catch (const std::exception& error) {
    sqlite3_result_error(context, error.what(), -1);
  }
}

// --- functions of one row ---

using Arguments = std::span<sqlite3_value*>;

double number(const Arguments& arguments, std::size_t i) { return sqlite3_value_double(arguments[i]); }
std::int64_t count(const Arguments& arguments, std::size_t i) { return sqlite3_value_int64(arguments[i]); }
std::string text(const Arguments& arguments, std::size_t i) {
  return reinterpret_cast<const char*>(sqlite3_value_text(arguments[i]));
}

template <auto function>
void call(sqlite3_context* context, int size, sqlite3_value** values) {
  const Arguments arguments(values, static_cast<std::size_t>(size));
  for (sqlite3_value* value : arguments) {
    if (sqlite3_value_type(value) == SQLITE_NULL) return sqlite3_result_null(context);
  }
  guarded(context, [&] { give(context, function(arguments)); });
}

Interval wilson_of(const Arguments& given) { return wilson(count(given, 0), count(given, 1)); }
Estimate log_mean_of(const Arguments& given) {
  return LogSums{count(given, 0), number(given, 1), number(given, 2)}.geometric_mean();
}
double mcnemar_of(const Arguments& given) { return mcnemar_exact(count(given, 0), count(given, 1)); }

Estimate difference_of(const Arguments& given) {
  return combination_of_shares(
      std::vector<double>{1, number(given, 0), number(given, 1), -1, number(given, 2), number(given, 3)});
}

/// The numbers of a text, separated by blanks, up to the first word that is none.
std::vector<double> numbers_of(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<double>(stream), std::istream_iterator<double>()};
}

/// A quantity of study/paper/claims.sql with its interval. The third argument, in (0, 1), is the probability that the
/// interval misses the quantity; without it 0.05.
Estimate estimate_of(const Arguments& given) {
  const std::string form = text(given, 0);
  const std::vector<double> terms = numbers_of(text(given, 1));
  const double z = given.size() > 2 ? normal_quantile(number(given, 2)) : kNormal975;
  if (form == "shares") return combination_of_shares(terms, z);
  if (form == "number" && terms.size() == 1) return {terms[0], kNoNumber, kNoNumber};
  if (form == "pairs" && terms.size() == 3) return paired_difference(terms[0], terms[1], terms[2], z);
  if (form == "means" && terms.size() == 6) return ratio_of_means(std::span<const double, 6>(terms), z);
  throw std::invalid_argument("estimate: unknown form, or wrong number of terms");
}

/// The p-value of McNemar's exact test for pairs, NaN for the other forms. claims.sql asks that the test, too, is
/// significant.
double p_of(const Arguments& given) {
  if (text(given, 0) != "pairs") return kNoNumber;
  const std::vector<double> terms = numbers_of(text(given, 1));
  if (terms.size() != 3) throw std::invalid_argument("estimate_p: pairs have three terms");
  return mcnemar_exact(static_cast<std::int64_t>(terms[1]), static_cast<std::int64_t>(terms[2]));
}

std::optional<std::string> name_of_spec(const Arguments& given) { return spec_or_name(text(given, 0)).name; }

std::optional<std::string> find_option(const Options& options, const std::string& key) {
  const auto found = std::find_if(options.begin(), options.end(), [&](const auto& each) { return each.first == key; });
  return found == options.end() ? std::nullopt : std::optional(found->second);
}

std::optional<std::string> option_of(const Arguments& given) {
  return find_option(spec_or_name(text(given, 0)).options, text(given, 1));
}

/// A setting of a solver, or else of the solver that its setting `solver` names; defaults count.
std::optional<std::string> find_setting(const std::string& solver, const std::string& key) {
  Spec spec = spec_or_name(solver);
  try {
    spec.options = find_solver(spec.name).definition.all_settings(spec.options);
  } catch (const InputError&) {  // a solver or setting of another version
  }
  const std::optional<std::string> found = find_option(spec.options, key);
  const std::optional<std::string> inner = found ? std::nullopt : find_option(spec.options, "solver");
  return inner ? find_setting(*inner, key) : found;
}

double setting_of(const Arguments& given) {
  const std::vector<double> numbers = numbers_of(find_setting(text(given, 0), text(given, 1)).value_or(""));
  return numbers.size() == 1 && std::isfinite(numbers[0]) ? numbers[0] : kNoNumber;
}

// --- aggregates ---

/// First arguments of a group's rows where they are not NULL, and the second argument of the last of these rows.
struct Sample {
  std::vector<double> values;
  double share = kNoNumber;
};

void collect(sqlite3_context* context, int count, sqlite3_value** arguments) {
  auto** slot = static_cast<Sample**>(sqlite3_aggregate_context(context, sizeof(Sample*)));
  if (slot == nullptr) return sqlite3_result_error_nomem(context);
  guarded(context, [&] {
    if (*slot == nullptr) *slot = new Sample;
    if (sqlite3_value_type(arguments[0]) == SQLITE_NULL) return;
    (*slot)->values.push_back(sqlite3_value_double(arguments[0]));
    if (count > 1) (*slot)->share = sqlite3_value_double(arguments[1]);
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

double quantile_of(Sample& sample) {
  if (sample.values.empty()) return kNoNumber;
  if (!(sample.share > 0 && sample.share <= 1)) throw std::invalid_argument("quantile: the share is not in (0, 1]");
  std::ranges::sort(sample.values);
  return quantile(sample.values, sample.share);
}

Estimate median_of(const Sample& sample) { return median_estimate(sample.values); }

// --- their names ---

using Function = void (*)(sqlite3_context*, int, sqlite3_value**);

/// A function of one row; with `last` an aggregate, for which `function` takes each row and `last` gives the result.
void add(sqlite::Database& database, const std::string& name, int arguments, Function function,
         void (*last)(sqlite3_context*) = nullptr) {
  const int code = sqlite3_create_function_v2(database.handle(), name.c_str(), arguments, kFlags, nullptr,
                                              last == nullptr ? function : nullptr,
                                              last == nullptr ? nullptr : function, last, nullptr);
  if (code != SQLITE_OK) database.fail(code);
}

template <auto function>
void add_function(sqlite::Database& database, const std::string& name, int arguments) {
  add(database, name, arguments, call<function>);
}

/// NAME_low and NAME_high.
template <auto function>
void add_interval(sqlite::Database& database, const std::string& name, int arguments) {
  add_function<[](const Arguments& given) { return function(given).low; }>(database, name + "_low", arguments);
  add_function<[](const Arguments& given) { return function(given).high; }>(database, name + "_high", arguments);
}

/// An aggregate with its interval: NAME, NAME_low and NAME_high.
template <auto function>
void add_estimate(sqlite::Database& database, const std::string& name, int arguments) {
  add(database, name, arguments, collect, finish<[](Sample& sample) { return function(sample).value; }>);
  add(database, name + "_low", arguments, collect, finish<[](Sample& sample) { return function(sample).low; }>);
  add(database, name + "_high", arguments, collect, finish<[](Sample& sample) { return function(sample).high; }>);
}

}  // namespace

void add_statistics_functions(sqlite::Database& database) {
  add_interval<wilson_of>(database, "wilson", 2);
  add_interval<difference_of>(database, "difference", 4);
  add_interval<log_mean_of>(database, "log_mean", 3);
  add_interval<estimate_of>(database, "estimate", 3);
  add_function<[](const Arguments& given) { return estimate_of(given).value; }>(database, "estimate", 2);
  add_function<p_of>(database, "estimate_p", 2);
  add_function<mcnemar_of>(database, "mcnemar", 2);
  add_function<name_of_spec>(database, "spec_name", 1);
  add_function<option_of>(database, "spec_option", 2);
  add_function<setting_of>(database, "solver_setting", 2);
  add_function<[](const Arguments& given) { return percent(number(given, 0)); }>(database, "percent", 1);
  add_function<[](const Arguments& given) { return duration(number(given, 0)); }>(database, "duration", 1);
  add_function<[](const Arguments& given) { return factor(number(given, 0)); }>(database, "factor", 1);
  add_function<[](const Arguments& given) { return scientific(number(given, 0)); }>(database, "scientific", 1);
  add_function<[](const Arguments& given) {
    return percent_range({number(given, 0), number(given, 1)});
  }>(database, "percent_range", 2);
  add_estimate<median_of>(database, "median", 1);
  add(database, "quantile", 2, collect, finish<quantile_of>);
  add(database, "sigma", 1, collect, finish<[](Sample& sample) { return spread(sample.values).sigma; }>);
}

}  // namespace lcpbench::report
