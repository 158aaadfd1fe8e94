#include "core/settings.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "core/error.h"
#include "core/suggestion.h"

namespace lcpbench {

std::string format_real(double value) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end};
}

namespace detail {

void throw_bad_value(std::string_view owner, std::string_view name, std::string_view value, std::string_view expected) {
  throw InputError(std::string(owner) + ": " + std::string(name) + " = '" + std::string(value) + "': expected " +
                   std::string(expected));
}

namespace {

template <class Number>
bool parse_number(std::string_view text, Number& value) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end;
}

}  // namespace

double parse_real(std::string_view owner, std::string_view name, std::string_view text, RealRange range) {
  double value = 0;
  if (!parse_number(text, value) || !(value >= range.min && value <= range.max)) {
    throw_bad_value(owner, name, text, "a number in " + range_text(range));
  }
  return value;
}

std::int64_t parse_integer(std::string_view owner, std::string_view name, std::string_view text, IntegerRange range) {
  std::int64_t value = 0;
  if (!parse_number(text, value) || value < range.min || value > range.max) {
    throw_bad_value(owner, name, text, "an integer in " + range_text(range));
  }
  return value;
}

bool parse_boolean(std::string_view owner, std::string_view name, std::string_view text) {
  if (text == "true") return true;
  if (text == "false") return false;
  throw_bad_value(owner, name, text, "true or false");
}

/// The interval is open at an infinite bound, because infinity is not a value of a setting.
std::string range_text(RealRange range) {
  constexpr double kLargest = std::numeric_limits<double>::max();
  const std::string low = range.min == -kLargest ? "(-inf" : "[" + format_real(range.min);
  const std::string high = range.max == kLargest ? "inf)" : format_real(range.max) + "]";
  return low + ", " + high;
}

std::string range_text(IntegerRange range) {
  using Limits = std::numeric_limits<std::int64_t>;
  const std::string low = range.min == Limits::min() ? "-2^63" : std::to_string(range.min);
  const std::string high = range.max == Limits::max() ? "2^63)" : std::to_string(range.max) + "]";
  return "[" + low + ", " + high;
}

void check_known(std::string_view owner, const Options& options, std::span<const std::string> known) {
  for (const auto& [key, value] : options) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    std::string names;
    for (const std::string& name : known) names += (names.empty() ? "" : ", ") + name;
    throw InputError(std::string(owner) + ": unknown option '" + key + "'" + did_you_mean(key, known) +
                     "; known: " + (names.empty() ? "none" : names));
  }
}

}  // namespace detail
}  // namespace lcpbench
