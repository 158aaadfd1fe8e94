#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/registry.h"
#include "core/stepper.h"
#include "generators/glob.h"
#include "generators/sets.h"
#include "study/commands/commands.h"
#include "study/commands/options.h"
#include "study/output/json_output.h"
#include "study/output/terminal.h"
#include "study/output/text_table.h"
#include "study/run/open_solver.h"

namespace lcpbench {
namespace {

using Json = nlohmann::ordered_json;

std::string origin(const RegisteredSolver& solver) {
  if (solver.native() || solver.version.empty()) return solver.library;
  return fmt::format("{} {}", solver.library, solver.version);
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
               {"origin", solver.native()       ? "native"
                          : solver.in_process() ? "captured"
                                                : "library"},
               {"library", solver.library},
               {"version", solver.version},
               {"available", reason.empty()},
               {"reason", reason},
               {"needs", to_string(capabilities.needs)},
               {"frictionless_only", capabilities.frictionless_only},
               {"friction_setting", capabilities.friction_setting},
               {"max_size", nullptr},
               {"guarantees", capabilities.guarantees},
               {"settings", settings_json(definition.settings())}};
  if (capabilities.max_size != Capabilities{}.max_size) json["max_size"] = capabilities.max_size;
  return json;
}

std::string limits(const Capabilities& capabilities) {
  std::string text = to_string(capabilities.needs);
  if (capabilities.frictionless_only) text += ", frictionless";
  if (capabilities.captured_only) text += ", captured steps";
  if (capabilities.max_size != Capabilities{}.max_size) text += fmt::format(", n <= {}", capabilities.max_size);
  return text;
}

void print_setting(const SettingInfo& setting, int width) {
  const std::string range = setting.range.empty() ? "" : "  " + setting.range;
  say(stdout, "{}",
      folded(fmt::format("    {} = {}{}\n        {}\n", setting.name, setting.default_value, range, setting.help),
             width));
}

using SolverList = std::vector<const RegisteredSolver*>;

/// @throws InputError for a pattern that matches none
SolverList matching_solvers(const std::string& pattern) {
  SolverList solvers;
  for (const RegisteredSolver& solver : registered_solvers()) {
    if (pattern.empty() || glob_matches(pattern, solver.definition.name)) solvers.push_back(&solver);
  }
  if (solvers.empty()) find_solver(pattern);  // says which there are
  return solvers;
}

/// Names under what they have in common, a line or two for each group.
class GroupedNames {
 public:
  void add(const std::string& group, const std::string& name) {
    auto known = std::find_if(groups_.begin(), groups_.end(), [&](const auto& each) { return each.first == group; });
    if (known == groups_.end()) known = groups_.emplace(groups_.end(), group, "");
    known->second += (known->second.empty() ? "" : ", ") + name;
  }
  std::string text(const char* title, const char* title_of_names, int width) const {
    TextTable table({{title, TextTable::Align::kLeft}, {title_of_names, TextTable::Align::kLeft}});
    for (const auto& [group, names] : groups_) table.add_row({group, names});
    return table.text(width);
  }

 private:
  std::vector<std::pair<std::string, std::string>> groups_;  // in the order in which they came
};

void print_solver_names(const SolverList& solvers, int width) {
  GroupedNames names;
  for (const bool available : {true, false}) {
    for (const RegisteredSolver* solver : solvers) {
      const std::string reason = why_unavailable(*solver);
      if (reason.empty() != available) continue;
      names.add(available ? origin(*solver) : "not here: " + reason, solver->definition.name);
    }
  }
  say(stdout, "{}{}", names.text("from", "solvers", width),
      folded("What a solver needs and guarantees, and its settings: lcpbench solvers NAME, with * and ?. Of all: "
             "--long.\n",
             width));
}

void print_solvers(const SolverList& solvers, int width) {
  using Align = TextTable::Align;
  TextTable table({{"solver", Align::kLeft},
                   {"origin", Align::kLeft, 1},
                   {"available", Align::kLeft, 2},
                   {"needs", Align::kLeft},
                   {"what it is", Align::kLeft, 0, 30}});
  for (const RegisteredSolver* solver : solvers) {
    const std::string reason = why_unavailable(*solver);
    table.add_row({solver->definition.name, origin(*solver), reason.empty() ? "yes" : "no: " + reason,
                   limits(solver->definition.capabilities), solver->definition.summary});
  }
  say(stdout, "{}", table.text(width));
  for (const RegisteredSolver* solver : solvers) {
    const SolverDefinition& definition = solver->definition;
    const std::string guarantees = definition.capabilities.guarantees;
    say(stdout, "{}",
        folded(fmt::format("\n{}\n    source: {}\n    guaranteed: {}\n", definition.name, definition.source,
                           guarantees.empty() ? "nothing" : guarantees),
               width));
    for (const SettingInfo& setting : definition.settings()) print_setting(setting, width);
  }
}

void print_steppers(const std::vector<StepperDefinition>& steppers, bool brief, int width) {
  using Align = TextTable::Align;
  TextTable table({{"stepper", Align::kLeft}, {"takes", Align::kLeft}, {"what it is", Align::kLeft, 0, 30}});
  for (const StepperDefinition& stepper : steppers) {
    table.add_row({stepper.name, stepper.bodies_only ? "free bodies" : "robots too", stepper.summary});
  }
  say(stdout, "{}", table.text(width));
  for (const StepperDefinition& stepper : brief ? std::vector<StepperDefinition>{} : steppers) {
    say(stdout, "{}", folded(fmt::format("\n{}\n    source: {}\n", stepper.name, stepper.source), width));
    for (const SettingInfo& setting : stepper.settings()) print_setting(setting, width);
  }
  if (brief)
    say(stdout, "{}", folded("Source and settings: lcpbench steppers NAME, with * and ?. Of all: --long.\n", width));
}

Json steppers_json(const std::vector<StepperDefinition>& steppers) {
  Json array = Json::array();
  for (const StepperDefinition& stepper : steppers) {
    array.push_back({{"name", stepper.name},
                     {"summary", stepper.summary},
                     {"source", stepper.source},
                     {"bodies_only", stepper.bodies_only},
                     {"settings", settings_json(stepper.settings())}});
  }
  return array;
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

/// Of the hard cases and of the captured scenes the list names the families only, so that it stays short.
std::string_view families_folder(const std::string& set) {
  for (const std::string_view folder : {"hard/", "scene/"}) {
    if (set.starts_with(folder)) return folder;
  }
  return "";
}

void print_set_names(const std::vector<SetInfo>& sets, int width) {
  GroupedNames names;
  std::string family;
  for (const SetInfo& info : sets) {
    const std::size_t slash = info.name.rfind('/') + 1;
    const std::string folder = info.name.substr(0, slash);
    const std::string_view families = families_folder(info.name);
    if (families.empty()) {
      names.add(folder, info.name.substr(slash));
    } else if (family != folder) {
      names.add(std::string(families), folder.substr(families.size()) + "*");
      family = folder;
    }
  }
  say(stdout, "{}{}", names.text("sets", "", width),
      folded("What a set holds, its source and its options: lcpbench sets NAME, with * and ?. Of all: --long.\n",
             width));
}

void print_sets(const std::vector<SetInfo>& sets, int width) {
  using Align = TextTable::Align;
  TextTable table({{"set", Align::kLeft}, {"size", Align::kLeft}, {"what it is", Align::kLeft, 0, 30}});
  for (const SetInfo& info : sets) table.add_row({info.name, info.size, info.summary});
  say(stdout, "{}", table.text(width));
  for (const SetInfo& info : sets) {
    say(stdout, "{}", folded(fmt::format("\n{}\n    source: {}\n", printable(info.name), info.source), width));
    for (const SettingInfo& option : info.options) print_setting(option, width);
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

struct ListArguments {
  std::string pattern;
  std::string format = "text";
  Extent extent;

  /// The names alone, where nobody asked for more.
  bool brief() const { return pattern.empty() && !extent.all && !extent.wide; }
};

std::shared_ptr<ListArguments> add_arguments(CLI::App& command, const char* pattern, const std::string& help) {
  const auto arguments = std::make_shared<ListArguments>();
  command.add_option(pattern, arguments->pattern, help);
  add_long_option(command, arguments->extent, "show all there is to know, not the names alone");
  add_wide_option(command, arguments->extent);
  add_format_option(command, arguments->format);
  return arguments;
}

int list_steppers(const ListArguments& arguments) {
  std::vector<StepperDefinition> steppers;
  for (const StepperDefinition& stepper : registered_steppers()) {
    if (arguments.pattern.empty() || glob_matches(arguments.pattern, stepper.name)) steppers.push_back(stepper);
  }
  if (steppers.empty()) find_stepper(arguments.pattern);  // says which there are
  if (arguments.format == "json") {
    print_json(steppers_json(steppers));
  } else {
    print_steppers(steppers, arguments.brief(), arguments.extent.width());
  }
  return kExitDone;
}

int list_solvers(const ListArguments& arguments) {
  const SolverList solvers = matching_solvers(arguments.pattern);
  if (arguments.format == "json") {
    Json array = Json::array();
    for (const RegisteredSolver* solver : solvers) array.push_back(solver_json(*solver));
    print_json(array);
  } else if (arguments.brief()) {
    print_solver_names(solvers, arguments.extent.width());
  } else {
    print_solvers(solvers, arguments.extent.width());
  }
  return kExitDone;
}

int list_problem_sets(const ListArguments& arguments) {
  const std::vector<SetInfo> sets = matching_sets(arguments.pattern);
  if (arguments.format == "json") {
    print_json(sets_json(sets));
  } else if (arguments.brief()) {
    print_set_names(sets, arguments.extent.width());
  } else {
    print_sets(sets, arguments.extent.width());
  }
  return kExitDone;
}

}  // namespace

Action add_solvers_command(CLI::App& command) {
  const auto arguments =
      add_arguments(command, "NAME", "only the solvers that this name, or glob with * and ?, matches");
  return [arguments] { return list_solvers(*arguments); };
}

Action add_steppers_command(CLI::App& command) {
  const auto arguments =
      add_arguments(command, "NAME", "only the steppers that this name, or glob with * and ?, matches");
  return [arguments] { return list_steppers(*arguments); };
}

Action add_sets_command(CLI::App& command) {
  const auto arguments =
      add_arguments(command, "PATTERN",
                    "only the sets that this name, or glob with * and ?, matches; {key=value} after it, or file:PATH");
  return [arguments] { return list_problem_sets(*arguments); };
}

}  // namespace lcpbench
