#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/settings.h"

namespace lcpbench {

/// One named experiment: what its problems are like (Features) and which options it reads (into a Reading).
template <class Features, class Reading>
struct ExperimentSet {
  std::string name;
  std::string stream;  ///< name of its random stream: that of another set when the problems are the same
  std::string summary;
  Features features;
  double condition = 0;  ///< 0 unless features.conditioned

  std::vector<SettingInfo> (*options)() = nullptr;
  Reading (*parse)(std::string_view owner, const Options&) = nullptr;    ///< throws InputError
  Options (*changed)(std::string_view owner, const Options&) = nullptr;  ///< off their defaults, in declaration order
};

/// Gives a set the options that Settings visits. They are read into Settings::reading.
template <class Settings, class Set>
void read_options_as(Set& set) {
  set.options = [] { return describe_settings<Settings>(); };
  set.parse = [](std::string_view owner, const Options& options) {
    return parse_settings<Settings>(owner, options).reading;
  };
  set.changed = [](std::string_view owner, const Options& options) {
    return changed_settings(parse_settings<Settings>(owner, options));
  };
}

/// Experiments 5 and 6 at their three condition numbers: calls add(name, stream, summary, condition) for each, 5
/// before 6.
/// @param prefix  of the names; `stream_prefix` of the random streams, which Experiment 6 shares with 5
template <class Add>
void for_each_conditioned_experiment(const std::string& prefix, const std::string& stream_prefix, Add add) {
  const std::pair<const char*, double> conditions[] = {{"1e5", 1e5}, {"1e8", 1e8}, {"1e10", 1e10}};
  for (const auto& [label, condition] : conditions) {
    const std::string five = std::string("exp5-") + label;
    add(prefix + five, stream_prefix + five,
        std::string("redundant contacts, eigenvalues of the inertia from 1 to ") + label, condition);
  }
  for (const auto& [label, condition] : conditions) {
    const std::string five = std::string("exp5-") + label;
    add(prefix + "exp6-" + label, stream_prefix + five, "the problems of " + five + ", for solvers that regularise",
        condition);
  }
}

}  // namespace lcpbench
