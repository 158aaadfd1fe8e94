#include "study/run/plan.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <limits>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/registry.h"
#include "core/suggestion.h"
#include "study/run/builtin_plans.h"

namespace lcpbench {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "lcpbench-plan";
constexpr std::int64_t kVersion = 1;
constexpr std::size_t kMaxPlanBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxEntries = 10'000;
constexpr std::size_t kMaxSweepCells = 10'000;
constexpr int kMaxDepth = 16;

/// A JSON value together with where it stands, so that every complaint names its place.
class Field {
 public:
  Field(const Json& value, std::string where) : value_(value), where_(std::move(where)) {}

  [[noreturn]] void fail(const std::string& cause) const { throw InputError(where_ + ": " + cause); }

  bool has(const char* key) const { return value_.contains(key); }
  Field at(const char* key) const {
    if (!has(key)) fail(fmt::format("'{}' is missing", key));
    return {value_.at(key), fmt::format("{}: {}", where_, key)};
  }
  bool is_text() const { return value_.is_string(); }

  void check_object(std::initializer_list<std::string_view> keys) const {
    if (!value_.is_object()) fail(fmt::format("expected an object, found {}", kind()));
    for (const auto& [key, value] : value_.items()) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) {
        fail(fmt::format("unknown key '{}'; known: {}", printable(key), fmt::join(keys, ", ")));
      }
    }
  }
  std::vector<Field> elements() const {
    if (!value_.is_array()) fail(fmt::format("expected an array, found {}", kind()));
    if (value_.size() > kMaxEntries) fail(fmt::format("more than {} entries", kMaxEntries));
    std::vector<Field> fields;
    for (std::size_t i = 0; i < value_.size(); ++i) fields.emplace_back(value_[i], fmt::format("{}[{}]", where_, i));
    return fields;
  }
  std::vector<std::pair<std::string, Field>> members() const {
    if (!value_.is_object()) fail(fmt::format("expected an object, found {}", kind()));
    std::vector<std::pair<std::string, Field>> fields;
    for (const auto& [key, value] : value_.items()) {
      fields.emplace_back(key, Field(value, fmt::format("{}: {}", where_, printable(key))));
    }
    return fields;
  }
  std::string text() const {
    if (!value_.is_string()) fail(fmt::format("expected a text, found {}", kind()));
    return value_.get<std::string>();
  }
  bool boolean() const {
    if (!value_.is_boolean()) fail(fmt::format("expected true or false, found {}", kind()));
    return value_.get<bool>();
  }
  std::int64_t integer(std::int64_t low, std::int64_t high) const {
    const bool fits =
        value_.is_number_integer() &&
        (!value_.is_number_unsigned() || value_.get<std::uint64_t>() <= std::numeric_limits<std::int64_t>::max());
    const std::int64_t value = fits ? value_.get<std::int64_t>() : 0;
    if (!fits || value < low || value > high) {
      fail(fmt::format("expected an integer in [{}, {}], found {}", low, high, shown()));
    }
    return value;
  }
  std::uint64_t unsigned_integer() const {
    if (!value_.is_number_unsigned()) fail(fmt::format("expected an integer in [0, 2^64), found {}", shown()));
    return value_.get<std::uint64_t>();
  }
  double positive_seconds() const {
    const double value = value_.is_number() ? value_.get<double>() : std::numeric_limits<double>::quiet_NaN();
    if (!(value > 0 && value <= kLongestSeconds)) {
      fail(fmt::format("expected seconds in (0, {}], found {}", kLongestSeconds, shown()));
    }
    return value;
  }
  double share() const {
    const double value = value_.is_number() ? value_.get<double>() : std::numeric_limits<double>::quiet_NaN();
    if (!(value > 0 && value <= 1)) fail(fmt::format("expected a number in (0, 1], found {}", shown()));
    return value;
  }
  double seconds() const { return value_.is_number() && value_.get<double>() == 0.0 ? 0.0 : positive_seconds(); }
  /// A setting's value: a number or a text.
  std::string setting() const {
    if (value_.is_string()) return text();
    if (value_.is_number_integer()) return value_.dump();
    if (value_.is_number() && std::isfinite(value_.get<double>())) return format_real(value_.get<double>());
    if (value_.is_boolean()) return value_.get<bool>() ? "true" : "false";
    fail(fmt::format("expected a number, a text, true or false, found {}", kind()));
  }

  /// Runs `parse`; an InputError of it gets this field's place in front.
  template <class Parse>
  auto located(Parse parse) const {
    try {
      return parse();
    } catch (const InputError& error) {
      fail(error.what());
    }
  }

  /// Errors are one line, whatever a hostile text holds.
  static std::string printable(std::string_view text) {
    constexpr std::size_t kLongest = 60;
    std::string result;
    for (const char c : text.substr(0, kLongest)) result += (c >= 0 && c < ' ') || c == 0x7f ? '?' : c;
    return text.size() > kLongest ? result + "..." : result;
  }

 private:
  static constexpr double kLongestSeconds = 1e7;

  const char* kind() const { return value_.type_name(); }
  std::string shown() const { return printable(value_.dump(-1, ' ', true, Json::error_handler_t::replace)); }

  const Json& value_;
  std::string where_;
};

std::string checked_name(const Field& field) {
  std::string name = field.text();
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' ||
           c == '.';
  };
  if (name.empty() || name.front() == '.' || name.size() > 100 || !std::all_of(name.begin(), name.end(), allowed)) {
    field.fail("expected a name of letters, digits, '-', '_' and '.'");
  }
  return name;
}

PlannedSet parse_set(const Field& field) {
  PlannedSet set;
  if (field.is_text()) {
    set.pattern = field.text();
    return set;
  }
  field.check_object({"set", "trials", "share"});
  set.pattern = field.at("set").text();
  if (field.has("trials")) set.trials = field.at("trials").integer(1, kMaxTrials);
  if (field.has("share")) set.share = field.at("share").share();
  if (set.trials && set.share) field.fail("'trials' and 'share' exclude each other");
  return set;
}

Sweep parse_sweep(const Field& field, const Spec& solver) {
  if (field.is_text()) return field.located([&] { return builtin_sweep(field.text(), solver); });
  field.check_object({"name", "grid"});
  Sweep sweep{checked_name(field.at("name")), {}};
  std::size_t cells = 1;
  for (const auto& [setting, values] : field.at("grid").members()) {
    SweepAxis axis{setting, {}};
    for (const Field& value : values.elements()) axis.values.push_back(value.setting());
    if (axis.values.empty()) values.fail("an axis needs a value");
    cells *= axis.values.size();
    if (cells > kMaxSweepCells) values.fail(fmt::format("the grid has more than {} cells", kMaxSweepCells));
    sweep.axes.push_back(std::move(axis));
  }
  if (sweep.axes.empty()) field.at("grid").fail("a grid needs an axis");
  return sweep;
}

Spec parse_solver_spec(const Field& field) {
  return field.located([&] { return canonical_solver_spec(parse_spec(field.text())); });
}

PlannedSolver parse_solver(const Field& field) {
  PlannedSolver solver;
  if (field.is_text()) {
    solver.spec = parse_solver_spec(field);
    return solver;
  }
  field.check_object({"solver", "every", "sweep", "sets", "optional"});
  solver.spec = parse_solver_spec(field.at("solver"));
  if (field.has("every")) solver.every = field.at("every").integer(1, kMaxTrials);
  if (field.has("optional")) solver.optional = field.at("optional").boolean();
  if (field.has("sets")) {
    for (const Field& pattern : field.at("sets").elements()) solver.sets.push_back(pattern.text());
    if (solver.sets.empty()) field.at("sets").fail("a solver needs a set");
  }
  if (field.has("sweep")) {
    const Field sweep = field.at("sweep");
    solver.sweep = parse_sweep(sweep, solver.spec);
    sweep.located([&] { return sweep_cells(*solver.sweep, solver.spec); });
  }
  return solver;
}

Plan parse_fields(const Field& field) {
  field.check_object({"format", "version", "name", "description", "seed", "trials", "time_limit_s", "repeat_until_s",
                      "budget_s", "jobs", "start", "sets", "solvers"});
  if (field.at("format").text() != kFormat) field.at("format").fail(fmt::format("expected '{}'", kFormat));
  field.at("version").integer(kVersion, kVersion);
  Plan plan;
  plan.name = checked_name(field.at("name"));
  if (field.has("description")) plan.description = field.at("description").text();
  if (field.has("seed")) plan.seed = field.at("seed").unsigned_integer();
  if (field.has("trials")) plan.trials = field.at("trials").integer(1, kMaxTrials);
  if (field.has("time_limit_s")) plan.time_limit_s = field.at("time_limit_s").positive_seconds();
  if (field.has("repeat_until_s")) plan.repeat_until_s = field.at("repeat_until_s").seconds();
  if (field.has("budget_s")) plan.budget_s = field.at("budget_s").positive_seconds();
  if (field.has("jobs")) plan.jobs = static_cast<int>(field.at("jobs").integer(1, 1024));
  if (field.has("start")) {
    plan.start_last = field.at("start").text() == "last";
    if (!plan.start_last) field.at("start").fail("expected 'last'");
  }
  for (const Field& set : field.at("sets").elements()) plan.sets.push_back(parse_set(set));
  for (const Field& solver : field.at("solvers").elements()) plan.solvers.push_back(parse_solver(solver));
  if (plan.sets.empty()) field.at("sets").fail("a plan needs a set");
  if (plan.solvers.empty()) field.at("solvers").fail("a plan needs a solver");
  return plan;
}

/// Parses JSON with two refusals that the library leaves out: nesting that could exhaust the stack of whoever walks it,
/// and a key given twice, of which it would silently keep the last.
Json parse_json(std::string_view text, const std::string& origin) {
  std::vector<std::vector<std::string>> keys;
  const auto watch = [&](int depth, Json::parse_event_t event, Json& parsed) {
    if (depth > kMaxDepth) throw InputError(fmt::format("{}: nested more than {} deep", origin, kMaxDepth));
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key) {
      std::string key = parsed.get<std::string>();
      if (std::find(keys.back().begin(), keys.back().end(), key) != keys.back().end()) {
        throw InputError(fmt::format("{}: key '{}' given twice", origin, Field::printable(key)));
      }
      keys.back().push_back(std::move(key));
    }
    return true;
  };
  try {
    return Json::parse(text.begin(), text.end(), watch);
  } catch (const Json::exception& error) {
    std::string cause = error.what();
    if (const auto bracket = cause.find("] "); bracket != std::string::npos) cause = cause.substr(bracket + 2);
    constexpr std::size_t kLongestCause = 200;
    std::string line;
    for (const char c : cause.substr(0, kLongestCause)) line += c >= 0 && c < ' ' ? ' ' : c;
    throw InputError(fmt::format("{}: not JSON: {}", origin, line));
  }
}

Json sweep_json(const Sweep& sweep) {
  Json grid = Json::object();
  for (const SweepAxis& axis : sweep.axes) grid[axis.setting] = axis.values;
  return {{"name", sweep.name}, {"grid", grid}};
}

Json solver_json(const PlannedSolver& solver) {
  Json json = {{"solver", solver.spec.text()}};
  if (solver.every != 1) json["every"] = solver.every;
  if (solver.sweep) json["sweep"] = sweep_json(*solver.sweep);
  if (!solver.sets.empty()) json["sets"] = solver.sets;
  if (solver.optional) json["optional"] = true;
  return json;
}

}  // namespace

Plan parse_plan(std::string_view text, const std::string& origin) {
  if (text.size() > kMaxPlanBytes) throw InputError(fmt::format("{}: more than {} bytes", origin, kMaxPlanBytes));
  const Json json = parse_json(text, origin);
  return parse_fields(Field(json, origin));
}

std::string plan_json(const Plan& plan) {
  Json json = {{"format", kFormat},
               {"version", kVersion},
               {"name", plan.name},
               {"description", plan.description},
               {"seed", plan.seed},
               {"trials", plan.trials},
               {"time_limit_s", plan.time_limit_s},
               {"repeat_until_s", plan.repeat_until_s}};
  if (plan.budget_s) json["budget_s"] = *plan.budget_s;
  if (plan.jobs) json["jobs"] = *plan.jobs;
  if (plan.start_last) json["start"] = "last";
  json["sets"] = Json::array();
  for (const PlannedSet& set : plan.sets) {
    Json entry = {{"set", set.pattern}};
    if (set.trials) entry["trials"] = *set.trials;
    if (set.share) entry["share"] = *set.share;
    json["sets"].push_back(entry);
  }
  json["solvers"] = Json::array();
  for (const PlannedSolver& solver : plan.solvers) json["solvers"].push_back(solver_json(solver));
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Plan load_plan(const std::string& name_or_file) {
  for (const BuiltinPlan& plan : kBuiltinPlans) {
    if (name_or_file == plan.name) return parse_plan(plan.text, "plan " + name_or_file);
  }
  std::error_code ignored;
  if (std::filesystem::is_directory(name_or_file, ignored)) {
    throw InputError(name_or_file + ": is a folder, expected a plan file");
  }
  if (!std::filesystem::is_regular_file(name_or_file, ignored)) {
    const std::vector<std::string> built_in = builtin_plan_names();
    throw InputError(fmt::format("plan '{}': neither a file nor built in ({}){}", name_or_file,
                                 fmt::join(built_in, ", "), did_you_mean(name_or_file, built_in)));
  }
  if (std::filesystem::file_size(name_or_file, ignored) == 0) throw InputError(name_or_file + ": empty file");
  if (std::filesystem::file_size(name_or_file, ignored) > kMaxPlanBytes) {
    throw InputError(fmt::format("{}: more than {} bytes", name_or_file, kMaxPlanBytes));
  }
  std::ifstream file(name_or_file, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file || !text) throw InputError(name_or_file + ": cannot be read");
  return parse_plan(text.str(), name_or_file);
}

std::vector<std::string> builtin_plan_names() {
  std::vector<std::string> names;
  for (const BuiltinPlan& plan : kBuiltinPlans) names.emplace_back(plan.name);
  return names;
}

std::string_view builtin_plan_text(const std::string& name) {
  for (const BuiltinPlan& plan : kBuiltinPlans) {
    if (name == plan.name) return plan.text;
  }
  throw InputError("no built-in plan '" + name + "'");
}

}  // namespace lcpbench
