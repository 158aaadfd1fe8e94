#include <algorithm>
#include <utility>

#include "core/registry.h"
#include "core/stepper.h"
#include "generators/hard/hard.h"
#include "generators/sets.h"
#include "study/commands/commands.h"
#include "study/output/columns.h"
#include "study/run/open_solver.h"

// Each list is one JSON document. What people read is made of it.

namespace lcpbench {
namespace {

// ---------------------------------------------------------------------------------------------------- documents

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
  const bool bounded = capabilities.max_size != Capabilities{}.max_size;
  return {{"name", definition.name},
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
          {"max_size", bounded ? Json(capabilities.max_size) : Json()},
          {"max_entries", capabilities.max_entries},
          {"guarantees", capabilities.guarantees},
          {"settings", settings_json(definition.settings())}};
}

/// @param wanted  a name, a pattern, or a name with settings
/// @throws InputError for a pattern that matches none, and for settings that the solver refuses
Json solvers_json(const std::string& wanted) {
  const bool has_settings = wanted.find('{') != std::string::npos;
  const std::string pattern = has_settings ? canonical_solver_spec(parse_spec(wanted)).name : wanted;
  Json array = Json::array();
  for (const RegisteredSolver& solver : registered_solvers()) {
    if (pattern.empty() || glob_matches(pattern, solver.definition.name)) array.push_back(solver_json(solver));
  }
  if (array.empty()) find_solver(pattern);  // says which there are
  return array;
}

/// @throws InputError for a pattern that matches none
Json steppers_json(const std::string& pattern) {
  Json array = Json::array();
  for (const StepperDefinition& stepper : registered_steppers()) {
    if (!pattern.empty() && !glob_matches(pattern, stepper.name)) continue;
    array.push_back({{"name", stepper.name},
                     {"summary", stepper.summary},
                     {"source", stepper.source},
                     {"bodies_only", stepper.bodies_only},
                     {"settings", settings_json(stepper.settings())}});
  }
  if (array.empty()) find_stepper(pattern);  // says which there are
  return array;
}

Json set_json(const SetInfo& info, const std::string& name) {
  const auto hard = name.starts_with("hard/") ? hard_case(name) : std::nullopt;  // its answer depends on the options
  return {{"name", name},
          {"size", info.size},
          {"source", info.source},
          {"summary", info.summary + (hard ? "; " + truth_text(*hard) : "")},
          {"options", settings_json(info.options)}};
}

/// The sets that expand_sets finds, under the canonical names that they have with the options given.
Json sets_json(const std::string& pattern) {
  const std::vector<SetInfo> listed = list_sets();
  Json array = Json::array();
  if (pattern.empty()) {
    for (const SetInfo& info : listed) array.push_back(set_json(info, info.name));
    return array;
  }
  for (const std::string& name : expand_sets(pattern)) {
    if (name.starts_with("file:")) {
      const auto count = static_cast<std::size_t>(open_set(name)->count().value_or(0));
      const SetInfo files{
          name, counted_noun(count, "problem"), "problem files", "problem files, in the order of their names", {}};
      array.push_back(set_json(files, name));
      continue;
    }
    const std::string family = parse_spec(name).name;
    array.push_back(set_json(
        *std::find_if(listed.begin(), listed.end(), [&](const SetInfo& info) { return info.name == family; }), name));
  }
  return array;
}

// --------------------------------------------------------------------------------------------------------- text

std::string text_of(const Json& entry, const char* key) { return entry[key].get<std::string>(); }

std::string origin(const Json& solver) {
  if (solver["origin"] == "native") return "lcpbench";  // as the report's page says
  const std::string version = text_of(solver, "version");
  return text_of(solver, "library") + (version.empty() ? "" : " " + version);
}

std::string needs(const Json& solver) {
  std::string text = text_of(solver, "needs");
  if (solver["frictionless_only"]) text += ", frictionless";
  if (solver["origin"] == "captured") text += ", captured steps";
  if (!solver["max_size"].is_null()) text += fmt::format(", n <= {}", solver["max_size"].get<Index>());
  if (solver["max_entries"] > 0) text += " or few coordinates";
  return text;
}

/// The group that a name stands in, in the short list, and the name there.
using Grouped = std::pair<std::string, std::string>;

Grouped grouped_solver(const Json& solver) {
  const std::string reason = text_of(solver, "reason");
  return {reason.empty() ? origin(solver) : "not here: " + reason, text_of(solver, "name")};
}

/// Of the hard cases and of the captured scenes the list names the families only, so that it stays short.
Grouped grouped_set(const Json& set) {
  const std::string name = text_of(set, "name");
  const std::size_t slash = name.rfind('/') + 1;
  for (const std::string folder : {"hard/", "scene/"}) {
    if (name.starts_with(folder)) return {folder, name.substr(folder.size(), slash - folder.size()) + "*"};
  }
  return {name.substr(0, slash), name.substr(slash)};
}

/// One of the lists: its JSON document, and how people see it.
struct Listing {
  const char* noun;
  Json (*document)(const std::string& pattern);
  Grouped (*grouped)(const Json& entry);  ///< nullptr: the short list is the table
  std::vector<JsonColumn> columns;
};

std::string short_list(const Listing& listing, const Json& entries) {
  std::vector<std::pair<std::string, std::vector<std::string>>> groups;  // in the order in which they come
  for (const Json& entry : entries) {
    const auto [group, name] = listing.grouped(entry);
    auto known = std::find_if(groups.begin(), groups.end(), [&](const auto& each) { return each.first == group; });
    if (known == groups.end()) known = groups.insert(known, {group, {}});
    if (known->second.empty() || known->second.back() != name) known->second.push_back(name);
  }
  std::stable_partition(groups.begin(), groups.end(), [](const auto& each) { return !each.first.starts_with("not "); });
  TextTable table({{"from", TextTable::Align::kLeft}, {fmt::format("{}s", listing.noun), TextTable::Align::kLeft}});
  for (const auto& [group, names] : groups) table.add_row({group, fmt::format("{}", fmt::join(names, ", "))});
  return table.text(text_width());
}

void print_details(const Json& entry) {
  std::string text = fmt::format("\n{}\n    source: {}\n", printable(text_of(entry, "name")), text_of(entry, "source"));
  if (entry.contains("guarantees")) {
    const std::string guarantees = text_of(entry, "guarantees");
    text += fmt::format("    guaranteed: {}\n", guarantees.empty() ? "nothing" : guarantees);
  }
  for (const Json& setting : entry[entry.contains("settings") ? "settings" : "options"]) {
    const std::string range = text_of(setting, "range");
    text += fmt::format("    {} = {}{}\n        {}\n", text_of(setting, "name"), text_of(setting, "default"),
                        range.empty() ? "" : "  " + range, text_of(setting, "help"));
  }
  say_folded("{}", text);
}

struct ListArguments {
  std::string pattern;
  bool all = false;
  bool json = false;
};

int list(const Listing& listing, const ListArguments& arguments) {
  const Json entries = listing.document(arguments.pattern);
  if (arguments.json) {
    print_json(entries);
    return kExitDone;
  }
  const bool brief = arguments.pattern.empty() && !arguments.all && text_width() != kUnlimited;
  const bool names_only = brief && listing.grouped != nullptr;
  say(stdout, "{}", names_only ? short_list(listing, entries) : table_text(listing.columns, entries));
  if (brief) {
    say_folded("Of one {0}, with its source and settings: lcpbench {0}s NAME, with * and ?. Of all: --long.\n",
               listing.noun);
    return kExitDone;
  }
  for (const Json& entry : entries) print_details(entry);
  return kExitDone;
}

Action add_list(CLI::App& command, const char* pattern, const std::string& help, Listing listing) {
  const auto arguments = std::make_shared<ListArguments>();
  command.add_option(pattern, arguments->pattern, help);
  command.add_flag("--long", arguments->all, "also show the source and the settings of each");
  add_output_options(command, arguments->json);
  return [arguments, listing = std::move(listing)] { return list(listing, *arguments); };
}

TextTable::Column left(const char* title, int rank = 0) { return {title, TextTable::Align::kLeft, rank}; }

const TextTable::Column kWhatItIs{"what it is", TextTable::Align::kLeft, 0, 30};

}  // namespace

Action add_solvers_command(CLI::App& command) {
  const auto available = [](const Json& solver) {
    return solver["available"] ? std::string("yes") : "no: " + text_of(solver, "reason");
  };
  return add_list(command, "NAME",
                  "only the solvers that this name, or glob with * and ?, matches; settings behind a name, as in "
                  "psor{relaxation=1}, are checked",
                  {"solver",
                   solvers_json,
                   grouped_solver,
                   {{left("solver"), field("name")},
                    {left("origin", 1), origin},
                    {left("available", 2), available},
                    {left("needs"), needs},
                    {kWhatItIs, field("summary")}}});
}

Action add_steppers_command(CLI::App& command) {
  const auto takes = [](const Json& stepper) {
    return std::string(stepper["bodies_only"] ? "free bodies" : "robots too");
  };
  return add_list(command, "NAME", "only the steppers that this name, or glob with * and ?, matches",
                  {"stepper",
                   steppers_json,
                   nullptr,
                   {{left("stepper"), field("name")}, {left("takes"), takes}, {kWhatItIs, field("summary")}}});
}

Action add_sets_command(CLI::App& command) {
  return add_list(command, "PATTERN",
                  "only the sets that this name, or glob with * and ?, matches; {key=value} after it, or file:PATH",
                  {"set",
                   sets_json,
                   grouped_set,
                   {{left("set"), field("name")}, {left("size"), field("size")}, {kWhatItIs, field("summary")}}});
}

}  // namespace lcpbench
