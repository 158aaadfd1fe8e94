#include "core/spec.h"

#include <algorithm>

#include "core/error.h"

namespace lcpbench {
namespace {

/// Braces inside each other: a solver in a solver is two of them.
constexpr int kMostBraces = 16;
constexpr std::size_t kMostOptions = 256;

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLongest = 200;
  return "'" + std::string(text.substr(0, kLongest)) + (text.size() > kLongest ? "...'" : "'");
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\n\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\n\r") - first + 1);
}

}  // namespace

std::string Spec::text() const {
  if (options.empty()) return name;
  std::string result = name + "{";
  for (std::size_t i = 0; i < options.size(); ++i) {
    if (i > 0) result += ",";
    result += options[i].first + "=" + options[i].second;
  }
  return result + "}";
}

std::vector<std::string> split_top_level(std::string_view text) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '{' && ++depth > kMostBraces) {
      throw InputError("more than " + std::to_string(kMostBraces) + " braces inside each other in " + in_quotes(text));
    }
    if (text[i] == '}' && --depth < 0) throw InputError("unbalanced '}' in " + in_quotes(text));
    if (text[i] == ',' && depth == 0) {
      parts.emplace_back(trimmed(text.substr(begin, i - begin)));
      begin = i + 1;
    }
  }
  if (depth != 0) throw InputError("missing '}' in " + in_quotes(text));
  parts.emplace_back(trimmed(text.substr(begin)));
  return parts;
}

Spec parse_spec(std::string_view whole) {
  const std::string_view text = trimmed(whole);
  Spec spec;
  const auto open = text.find('{');
  spec.name = std::string(trimmed(text.substr(0, open)));
  if (spec.name.empty()) throw InputError("no name in " + in_quotes(whole));
  if (spec.name.find_first_of("}=,") != std::string::npos) {
    throw InputError("unexpected character in the name " + in_quotes(spec.name));
  }
  if (open == std::string_view::npos) return spec;
  if (text.back() != '}') throw InputError("text after the closing brace, or no closing brace, in " + in_quotes(whole));
  const std::string_view inside = text.substr(open + 1, text.size() - open - 2);
  if (trimmed(inside).empty()) return spec;
  for (const std::string& part : split_top_level(inside)) {
    const auto equals = part.find('=');
    if (equals == std::string::npos)
      throw InputError("expected key=value, found " + in_quotes(part) + " in " + in_quotes(whole));
    std::string key(trimmed(std::string_view(part).substr(0, equals)));
    std::string value(trimmed(std::string_view(part).substr(equals + 1)));
    if (key.empty() || key.find_first_of("{}") != std::string::npos) {
      throw InputError("bad key in " + in_quotes(part) + " in " + in_quotes(whole));
    }
    const bool repeated =
        std::any_of(spec.options.begin(), spec.options.end(), [&](const auto& option) { return option.first == key; });
    if (repeated) throw InputError("key '" + key + "' given twice in " + in_quotes(whole));
    if (spec.options.size() == kMostOptions) {
      throw InputError("more than " + std::to_string(kMostOptions) + " options in " + in_quotes(whole));
    }
    spec.options.emplace_back(std::move(key), std::move(value));
  }
  return spec;
}

}  // namespace lcpbench
