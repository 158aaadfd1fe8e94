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

}  // namespace

void Reader::operator()(const char* name, double& value, RealRange range, const char*) {
  const std::string* text = find(name);
  if (text == nullptr) return;
  if (!parse_number(*text, value) || !(value >= range.min && value <= range.max)) {
    throw_bad_value(owner_, name, *text, "a number in " + range_text(range));
  }
}

void Reader::operator()(const char* name, std::int64_t& value, IntegerRange range, const char*) {
  const std::string* text = find(name);
  if (text == nullptr) return;
  if (!parse_number(*text, value) || value < range.min || value > range.max) {
    throw_bad_value(owner_, name, *text, "an integer in " + range_text(range));
  }
}

void Reader::operator()(const char* name, bool& value, const char*) {
  const std::string* text = find(name);
  if (text == nullptr) return;
  if (*text != "true" && *text != "false") throw_bad_value(owner_, name, *text, "true or false");
  value = *text == "true";
}

void Reader::operator()(const char* name, std::string& value, const char*) {
  if (const std::string* text = find(name)) value = *text;
}

void Reader::check_all_known() const {
  for (const auto& [key, value] : options_) {
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    std::string names;
    for (const std::string& name : known_) names += (names.empty() ? "" : ", ") + name;
    throw InputError(std::string(owner_) + ": unknown option '" + key + "'" + did_you_mean(key, known_) +
                     "; known: " + (names.empty() ? "none" : names));
  }
}

const std::string* Reader::find(const char* name) {
  known_.emplace_back(name);
  for (const auto& [key, value] : options_) {
    if (key == name) return &value;
  }
  return nullptr;
}

void Writer::operator()(const char* name, double& value, RealRange range, const char* help) {
  add(name, "real", format_real(value), range_text(range), help);
}

void Writer::operator()(const char* name, std::int64_t& value, IntegerRange range, const char* help) {
  add(name, "integer", std::to_string(value), range_text(range), help);
}

void Writer::operator()(const char* name, bool& value, const char* help) {
  add(name, "boolean", value ? "true" : "false", "true|false", help);
}

void Writer::operator()(const char* name, std::string& value, const char* help) { add(name, "text", value, "", help); }

void Writer::add(const char* name, const char* type, std::string value, std::string range, const char* help) {
  settings.push_back({name, type, std::move(value), std::move(range), help});
}

}  // namespace detail
}  // namespace lcpbench
