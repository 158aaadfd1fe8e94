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

void Fields::operator()(const char* name, double& value, RealRange range, const char* help) {
  const std::string* text = find(name);
  if (text != nullptr && (!parse_number(*text, value) || !(value >= range.min && value <= range.max))) {
    refuse(name, *text, "a number in " + range_text(range));
  }
  settings.push_back({name, "real", format_real(value), range_text(range), help});
}

void Fields::operator()(const char* name, std::int64_t& value, IntegerRange range, const char* help) {
  const std::string* text = find(name);
  if (text != nullptr && (!parse_number(*text, value) || value < range.min || value > range.max)) {
    refuse(name, *text, "an integer in " + range_text(range));
  }
  settings.push_back({name, "integer", std::to_string(value), range_text(range), help});
}

void Fields::operator()(const char* name, bool& value, const char* help) {
  if (const std::string* text = find(name)) {
    if (*text != "true" && *text != "false") refuse(name, *text, "true or false");
    value = *text == "true";
  }
  settings.push_back({name, "boolean", value ? "true" : "false", "true|false", help});
}

void Fields::operator()(const char* name, std::string& value, const char* help) {
  if (const std::string* text = find(name)) value = *text;
  settings.push_back({name, "text", value, "", help});
}

std::size_t Fields::choose(const char* name, const std::vector<const char*>& names, std::size_t chosen,
                           const char* help) {
  std::string range;
  for (const char* choice : names) range.append(range.empty() ? "" : "|").append(choice);
  if (const std::string* text = find(name)) {
    const auto found = std::find(names.begin(), names.end(), *text);
    if (found == names.end()) refuse(name, *text, range);
    chosen = static_cast<std::size_t>(found - names.begin());
  }
  settings.push_back({name, "choice", names[chosen], range, help});
  return chosen;
}

void Fields::check_all_known() const {
  std::vector<std::string> known;
  std::string list;
  for (const SettingInfo& setting : settings) {
    known.push_back(setting.name);
    list += (list.empty() ? "" : ", ") + setting.name;
  }
  for (const auto& [key, value] : options_) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    throw InputError(std::string(owner_) + ": unknown option '" + key + "'" + did_you_mean(key, known) + "; known: " +
                     (list.empty() ? "none" : list));
  }
}

const std::string* Fields::find(std::string_view name) const {
  for (const auto& [key, value] : options_) {
    if (key == name) return &value;
  }
  return nullptr;
}

void Fields::refuse(const char* name, const std::string& text, const std::string& expected) const {
  throw InputError(std::string(owner_) + ": " + name + " = '" + text + "': expected " + expected);
}

}  // namespace detail
}  // namespace lcpbench
