#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/spec.h"

namespace lcpbench {

/// One setting, as `lcpbench solvers` and the documentation show it.
struct SettingInfo {
  std::string name;
  std::string type;           ///< "real", "integer", "boolean", "choice" or "text"
  std::string default_value;  ///< in the form that a spec takes
  std::string range;          ///< "[0, 1e300]", "dense|kernel", "" for text
  std::string help;           ///< one line
};

struct RealRange {
  double min = -std::numeric_limits<double>::max();
  double max = std::numeric_limits<double>::max();
};
struct IntegerRange {
  std::int64_t min = std::numeric_limits<std::int64_t>::min();
  std::int64_t max = std::numeric_limits<std::int64_t>::max();
};
template <class Enum>
struct Choices {
  std::vector<std::pair<const char*, Enum>> values;
};

/// Shortest decimal text that reads back to the same double.
std::string format_real(double value);

// A settings struct lists its fields once, in visit(); text, parsing, ranges, help and defaults all come from there:
//
//   struct LemkeSettings {
//     double zero_tolerance = 1e-12;
//     Engine engine = Engine::kDense;
//     void visit(auto&& field) {
//       field("zero_tolerance", zero_tolerance, RealRange{.min = 0}, "added to x_i in the ratio test");
//       field("engine", engine, Choices<Engine>{{{"dense", Engine::kDense}, {"kernel", Engine::kKernel}}}, "...");
//     }
//   };
//
// Fields may be double, std::int64_t, bool, std::string, or an enum with Choices. (bool and std::string take no range:
// field(name, value, help).)

namespace detail {

/// Visits the fields of a settings struct: reads those that the options name, and lists all of them.
class Fields {
 public:
  /// @param options  must outlive this object
  Fields(std::string_view owner, const Options& options) : owner_(owner), options_(options) {}

  void operator()(const char* name, double& value, RealRange range, const char* help);
  void operator()(const char* name, std::int64_t& value, IntegerRange range, const char* help);
  void operator()(const char* name, bool& value, const char* help);
  void operator()(const char* name, std::string& value, const char* help);
  template <class Enum>
  void operator()(const char* name, Enum& value, const Choices<Enum>& choices, const char* help) {
    std::vector<const char*> names;
    std::size_t chosen = 0;
    for (const auto& [choice, meaning] : choices.values) {
      if (meaning == value) chosen = names.size();
      names.push_back(choice);
    }
    value = choices.values[choose(name, names, chosen, help)].second;
  }
  /// Throws InputError naming an unknown key and the known ones.
  void check_all_known() const;

  std::vector<SettingInfo> settings;  ///< with the values after reading

 private:
  const std::string* find(std::string_view name) const;
  [[noreturn]] void refuse(const char* name, const std::string& text, const std::string& expected) const;
  /// @returns the index of the choice in `names`. @param chosen  of the present value, kept if no option names one
  std::size_t choose(const char* name, const std::vector<const char*>& names, std::size_t chosen, const char* help);

  std::string_view owner_;
  const Options& options_;
};

}  // namespace detail

/// Every field of a settings struct with its present value as `default_value`.
template <class Settings>
std::vector<SettingInfo> describe_settings(Settings settings = {}) {
  const Options none;
  detail::Fields fields("", none);
  settings.visit(fields);
  return std::move(fields.settings);
}

/// Reads options into a settings struct; fields not named keep their defaults.
/// @param owner what the options belong to, for error messages ("lemke", "paper/monotone/exp2")
/// @throws InputError on an unknown key or a value of the wrong type or out of range (NaN is always out of range).
template <class Settings>
Settings parse_settings(std::string_view owner, const Options& options) {
  Settings settings;
  detail::Fields fields(owner, options);
  settings.visit(fields);
  fields.check_all_known();
  return settings;
}

/// All settings in declaration order, "key=value,key=value"; the form of the results' `settings` column.
template <class Settings>
Options all_settings(const Settings& settings) {
  Options options;
  for (SettingInfo& info : describe_settings(settings)) options.emplace_back(info.name, info.default_value);
  return options;
}

/// Only those that differ from their defaults: the short, canonical form of a spec.
template <class Settings>
Options changed_settings(const Settings& settings) {
  Options options;
  const std::vector<SettingInfo> defaults = describe_settings(Settings{});
  const std::vector<SettingInfo> present = describe_settings(settings);
  for (std::size_t i = 0; i < present.size(); ++i) {
    if (present[i].default_value != defaults[i].default_value) {
      options.emplace_back(present[i].name, present[i].default_value);
    }
  }
  return options;
}

}  // namespace lcpbench
