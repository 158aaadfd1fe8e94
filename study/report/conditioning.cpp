#include "study/report/conditioning.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <regex>

#include <fmt/format.h>

#include "core/error.h"
#include "core/spec.h"
#include "study/report/figures.h"

namespace lcpbench::report {

namespace {

using Json = nlohmann::ordered_json;

std::optional<Spec> spec_of(const std::string& set) {
  try {
    return parse_spec(set);
  } catch (const InputError&) {
    return std::nullopt;  // the name of a file
  }
}

std::optional<double> condition_number(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  const bool whole = end == text.c_str() + text.size() && !text.empty();
  return whole && std::isfinite(value) && value >= 1 ? std::optional(value) : std::nullopt;
}

/// A set of the store and where it stands in its family.
struct Member {
  double condition = 0;
  std::size_t set = 0;
};

/// The weakest of the members' measures: all have it, and no two measures meet in one family.
ErrorMeasure common_measure(const Summary& summary, const std::vector<Member>& members) {
  const bool all_forward = std::all_of(members.begin(), members.end(), [&](const Member& member) {
    return best_measure(summary.sets[member.set]) == ErrorMeasure::kForward;
  });
  return all_forward ? ErrorMeasure::kForward : ErrorMeasure::kResidual;
}

std::vector<std::size_t> recurring_solvers(const std::vector<SpeedError>& steps) {
  std::map<std::size_t, int> seen;
  for (const SpeedError& step : steps) {
    for (const SpeedErrorPoint& point : step.points) {
      if (point.placed()) ++seen[point.cell->solver];
    }
  }
  std::vector<std::size_t> solvers;
  for (const auto& [solver, times] : seen) {
    if (times >= 2) solvers.push_back(solver);
  }
  return solvers;
}

Conditioning make_family(const Summary& summary, const std::string& name, std::vector<Member> members) {
  std::sort(members.begin(), members.end(), [](const Member& a, const Member& b) { return a.condition < b.condition; });
  Conditioning family;
  family.family = name;
  family.measure = common_measure(summary, members);
  for (const Member& member : members) {
    family.conditions.push_back(member.condition);
    family.steps.push_back(speed_error(summary, member.set, family.measure));
  }
  const bool relative =
      std::all_of(family.steps.begin(), family.steps.end(), [](const SpeedError& step) { return step.relative; });
  if (!relative) {
    for (SpeedError& step : family.steps) step = speed_error(summary, step.set, family.measure, false);
  }
  family.solvers = recurring_solvers(family.steps);
  return family;
}

}  // namespace

std::optional<ConditionDial> condition_dial(const std::string& set) {
  const std::optional<Spec> spec = spec_of(set);
  if (!spec || !(spec->name.starts_with("paper/") || spec->name.starts_with("rigid/"))) return std::nullopt;
  Spec family = *spec;
  for (auto& [key, value] : family.options) {
    if (key != "condition") continue;
    const std::optional<double> condition = condition_number(value);
    if (!condition) return std::nullopt;
    value = "*";
    return ConditionDial{family.text(), *condition, true};
  }
  std::smatch match;
  static const std::regex conditioned("(.*/exp[56]-)(1e[0-9]+)");
  if (!std::regex_match(spec->name, match, conditioned)) return std::nullopt;
  const std::optional<double> condition = condition_number(match[2].str());
  if (!condition) return std::nullopt;
  family.name = match[1].str() + "*";
  return ConditionDial{family.text(), *condition, false};
}

std::string condition_text(double condition) {
  static const std::regex padding("e\\+0*");
  const double exponent = std::log10(condition);
  if (exponent == std::round(exponent)) return fmt::format("1e{:.0f}", exponent);
  return std::regex_replace(fmt::format("{:g}", condition), padding, "e");
}

std::vector<Conditioning> conditioning(const Summary& summary) {
  std::vector<std::string> names;
  std::map<std::string, std::vector<Member>> families;
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    const std::optional<ConditionDial> dial = condition_dial(summary.sets[set].name);
    if (!dial || !summary.sets[set].contact || drawn_cells(summary, set).empty()) continue;
    std::vector<Member>& members = families[dial->family];
    if (members.empty()) names.push_back(dial->family);
    members.push_back({dial->condition, set});
  }
  std::vector<Conditioning> result;
  for (const std::string& name : names) {
    if (families[name].size() >= 2) result.push_back(make_family(summary, name, families[name]));
  }
  return result;
}

bool SpeedErrorStudy::is_step(const Summary& summary, std::size_t set) const {
  const std::optional<ConditionDial> dial = condition_dial(summary.sets[set].name);
  return dial && dial->by_option && std::any_of(families.begin(), families.end(), [&](const Conditioning& family) {
           return family.family == dial->family;
         });
}

SpeedErrorStudy speed_error_study(const Summary& summary) { return {speed_errors(summary), conditioning(summary)}; }

Json conditioning_json(const Summary& summary, const std::vector<Conditioning>& families) {
  Json records = Json::array();
  for (const Conditioning& family : families) {
    for (std::size_t i = 0; i < family.steps.size(); ++i) {
      for (const SpeedErrorPoint& point : family.steps[i].points) {
        Json record{{"family", family.family}, {"condition", family.conditions[i]}};
        record.update(point_json(summary, family.steps[i], point));
        records.push_back(std::move(record));
      }
    }
  }
  return records;
}

}  // namespace lcpbench::report
