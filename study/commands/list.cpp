#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/registry.h"
#include "generators/sets.h"
#include "study/commands/commands.h"
#include "study/commands/options.h"
#include "study/json_output.h"
#include "study/open_solver.h"
#include "study/terminal.h"
#include "study/text_table.h"

namespace lcpbench {
namespace {

using Json = nlohmann::ordered_json;

std::string origin(const RegisteredSolver& solver) {
  return solver.native() ? solver.library : fmt::format("{} {}", solver.library, solver.version);
}

Json settings_json(const std::vector<SettingInfo>& settings) {
  Json array = Json::array();
  for (const SettingInfo& setting : settings) {
    array.push_back({{"name", setting.name},
                     {"type", setting.type},
                     {"default", setting.default_value},
                     {"range", setting.range},
                     {"help", setting.help}});
  }
  return array;
}

Json solver_json(const RegisteredSolver& solver) {
  const SolverDefinition& definition = solver.definition;
  const Capabilities& capabilities = definition.capabilities;
  const std::string reason = why_unavailable(solver);
  Json json = {{"name", definition.name},
               {"summary", definition.summary},
               {"source", definition.source},
               {"origin", solver.native() ? "native" : "library"},
               {"library", solver.library},
               {"version", solver.version},
               {"available", reason.empty()},
               {"reason", reason},
               {"needs", to_string(capabilities.needs)},
               {"frictionless_only", capabilities.frictionless_only},
               {"max_size", nullptr},
               {"guarantees", capabilities.guarantees},
               {"settings", settings_json(definition.settings())}};
  if (capabilities.max_size != Capabilities{}.max_size) json["max_size"] = capabilities.max_size;
  return json;
}

std::string limits(const Capabilities& capabilities) {
  std::string text = to_string(capabilities.needs);
  if (capabilities.frictionless_only) text += ", frictionless";
  if (capabilities.max_size != Capabilities{}.max_size) text += fmt::format(", n <= {}", capabilities.max_size);
  return text;
}

void print_setting(const SettingInfo& setting) {
  const std::string range = setting.range.empty() ? "" : "  " + setting.range;
  say(stdout, "    {} = {}{}\n        {}\n", setting.name, setting.default_value, range, setting.help);
}

void print_solvers() {
  using Align = TextTable::Align;
  TextTable table({{"solver", Align::kLeft},
                   {"origin", Align::kLeft},
                   {"available", Align::kLeft},
                   {"needs", Align::kLeft},
                   {"what it is", Align::kLeft}});
  for (const RegisteredSolver& solver : registered_solvers()) {
    const std::string reason = why_unavailable(solver);
    table.add_row({solver.definition.name, origin(solver), reason.empty() ? "yes" : "no: " + reason,
                   limits(solver.definition.capabilities), solver.definition.summary});
  }
  say(stdout, "{}", table.text());
  for (const RegisteredSolver& solver : registered_solvers()) {
    const SolverDefinition& definition = solver.definition;
    say(stdout, "\n{}\n    source: {}\n", definition.name, definition.source);
    const std::string guarantees = definition.capabilities.guarantees;
    say(stdout, "    guaranteed: {}\n", guarantees.empty() ? "nothing" : guarantees);
    for (const SettingInfo& setting : definition.settings()) print_setting(setting);
  }
}

/// A set of files, where `name` says that it is one.
std::optional<SetInfo> file_set(const std::string& name) {
  if (name.rfind("file:", 0) != 0) return std::nullopt;
  const std::int64_t count = open_set(name)->count().value_or(0);
  return SetInfo{name,
                 fmt::format("{} problem{}", format_count(count), count == 1 ? "" : "s"),
                 "problem files",
                 "problem files, in the order of their names",
                 {}};
}

/// The sets that expand_sets finds, under the canonical names that they have with the options given.
std::vector<SetInfo> matching_sets(const std::string& pattern) {
  const std::vector<SetInfo> listed = list_sets();
  if (pattern.empty()) return listed;
  std::vector<SetInfo> found;
  for (const std::string& name : expand_sets(pattern)) {
    if (std::optional<SetInfo> files = file_set(name)) {
      found.push_back(std::move(*files));
      continue;
    }
    const std::string family = parse_spec(name).name;
    found.push_back(
        *std::find_if(listed.begin(), listed.end(), [&](const SetInfo& info) { return info.name == family; }));
    found.back().name = name;
  }
  return found;
}

void print_sets(const std::vector<SetInfo>& sets, bool with_options) {
  using Align = TextTable::Align;
  TextTable table({{"set", Align::kLeft}, {"size", Align::kLeft}, {"what it is", Align::kLeft}});
  for (const SetInfo& info : sets) table.add_row({info.name, info.size, info.summary});
  say(stdout, "{}", table.text());
  if (!with_options) {
    say(stdout, "\nSource and options of a set: lcpbench sets NAME\n");
    return;
  }
  for (const SetInfo& info : sets) {
    say(stdout, "\n{}\n    source: {}\n", info.name, info.source);
    for (const SettingInfo& option : info.options) print_setting(option);
  }
}

Json sets_json(const std::vector<SetInfo>& sets) {
  Json array = Json::array();
  for (const SetInfo& info : sets) {
    array.push_back({{"name", info.name},
                     {"size", info.size},
                     {"source", info.source},
                     {"summary", info.summary},
                     {"options", settings_json(info.options)}});
  }
  return array;
}

}  // namespace

Action add_solvers_command(CLI::App& command) {
  const auto format = std::make_shared<std::string>("text");
  add_format_option(command, *format);
  return [format] {
    if (*format == "json") {
      Json array = Json::array();
      for (const RegisteredSolver& solver : registered_solvers()) array.push_back(solver_json(solver));
      print_json(array);
    } else {
      print_solvers();
    }
    return kExitDone;
  };
}

Action add_sets_command(CLI::App& command) {
  const auto format = std::make_shared<std::string>("text");
  const auto pattern = std::make_shared<std::string>();
  command.add_option("PATTERN", *pattern,
                     "only the sets that this name, or glob with * and ?, matches; {key=value} after it, or file:PATH");
  add_format_option(command, *format);
  return [format, pattern] {
    const std::vector<SetInfo> sets = matching_sets(*pattern);
    if (*format == "json") {
      print_json(sets_json(sets));
    } else {
      print_sets(sets, !pattern->empty());
    }
    return kExitDone;
  };
}

}  // namespace lcpbench
