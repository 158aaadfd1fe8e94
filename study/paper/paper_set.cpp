#include "study/paper/paper_set.h"

#include <algorithm>
#include <regex>

#include "core/error.h"

namespace lcpbench::paper {

namespace {

constexpr std::string_view kRedundancy = "redundancy";
constexpr std::string_view kRegularized = "regularized";
constexpr const char* kDefaultWrapped = "lemke";  // what `regularized` wraps unless its setting `solver` says otherwise

/// The value of an option, nullptr when it is not given.
const std::string* find_option(const Options& options, std::string_view key) {
  const auto found =
      std::find_if(options.begin(), options.end(), [key](const auto& option) { return option.first == key; });
  return found == options.end() ? nullptr : &found->second;
}

}  // namespace

Spec spec_or_name(const std::string& text) {
  try {
    return parse_spec(text);
  } catch (const InputError&) {
    return {text, {}};
  }
}

std::optional<PaperSet> paper_set(const std::string& name) {
  static const std::regex paper("paper/(monotone|copositive)/(exp[1-4]|exp[56]-1e(5|8|10)|extra100)");
  const Spec spec = spec_or_name(name);
  std::smatch parts;
  if (!std::regex_match(spec.name, parts, paper)) return std::nullopt;
  PaperSet set{parts[1], parts[2], parts[2] != "exp1" && parts[2] != "exp3", "multiple", ""};
  for (const auto& [key, value] : spec.options) {
    if (key == kRedundancy) set.redundancy = value;
    else set.other_readings += (set.other_readings.empty() ? "" : ",") + key + "=" + value;
  }
  return set;
}

std::string wrapped_solver(const std::string& solver) {
  const Spec spec = spec_or_name(solver);
  if (spec.name != kRegularized) return "";
  const std::string* wrapped = find_option(spec.options, "solver");
  return wrapped == nullptr ? kDefaultWrapped : *wrapped;
}

std::string family_of(const std::string& solver) {
  const std::string wrapped = wrapped_solver(solver);
  const std::string name = spec_or_name(wrapped.empty() ? solver : wrapped).name;
  return name == "lemke" ? "Lemke" : name == "path" ? "PATH" : name == "primal_dual" ? "IP" : "";
}

bool follows_rules_2012(const std::string& solver) {
  const std::string wrapped = wrapped_solver(solver);
  const Spec spec = spec_or_name(wrapped.empty() ? solver : wrapped);
  const std::string* rules = find_option(spec.options, "rules");
  return rules != nullptr && *rules == "2012";
}

}  // namespace lcpbench::paper
