#include "study/run/plan.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/error.h"
#include "core/io/json_document.h"
#include "core/io/whole_file.h"
#include "core/registry.h"
#include "core/suggestion.h"
#include "core/utf8.h"

namespace lcpbench {
namespace {

constexpr const char* kFormat = "lcpbench-plan";
constexpr std::int64_t kVersion = 1;
constexpr std::size_t kMaxPlanBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxSweepCells = 10'000;
constexpr double kLongestSeconds = 1e7;

/// Returns the result of `parse`, and puts the field's place in front of the message of its InputError.
template <class Parse>
auto located(const JsonObject& object, std::string_view field, Parse parse) {
  try {
    return parse();
  } catch (const InputError& error) {
    object.fail(field, std::string(": ") + error.what());
  }
}

std::string checked_name(const JsonObject& object) {
  const std::string& name = object.text("name");
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' ||
           c == '.';
  };
  if (name.empty() || name.front() == '.' || name.size() > 100 || !std::all_of(name.begin(), name.end(), allowed)) {
    object.fail("name", ": expected a name of letters, digits, '-', '_' and '.'");
  }
  return name;
}

/// A number in (0, most].
double positive(const JsonObject& object, std::string_view field, double most) {
  const double found = object.number(field);
  if (!(found > 0 && found <= most)) {
    object.fail(field, fmt::format(" is {}, expected a number in (0, {}]", format_real(found), most));
  }
  return found;
}

PlannedSet parse_set(const JsonObject& object) {
  object.only({"set", "trials", "share"});
  PlannedSet set{.pattern = object.text("set")};
  if (object.given("trials")) set.trials = object.integer("trials", 1, kMaxTrials);
  if (object.given("share")) set.share = positive(object, "share", 1);
  if (set.trials && set.share) object.fail("trials", " and 'share' exclude each other");
  return set;
}

/// A setting's value: a number, a text, true or false.
std::string setting_text(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  return value.is_number_float() ? format_real(value.get<double>()) : value.dump();
}

Sweep parse_sweep(const JsonObject& object) {
  object.only({"name", "grid"});
  Sweep sweep{checked_name(object), {}};
  const JsonObject grid = object.inside("grid");
  std::size_t cells = 1;
  for (const auto& [setting, values] : object.value("grid").items()) {
    SweepAxis axis{setting, {}};
    if (!values.is_array() || values.empty()) grid.fail(printable(setting), ": expected a list of values");
    for (const Json& value : values) {
      if (value.is_structured() || value.is_null()) grid.fail(printable(setting), ": a value is no number and no text");
      axis.values.push_back(setting_text(value));
    }
    cells *= axis.values.size();
    if (cells > kMaxSweepCells) grid.fail(printable(setting), fmt::format(": more than {} cells", kMaxSweepCells));
    sweep.axes.push_back(std::move(axis));
  }
  if (sweep.axes.empty()) object.fail("grid", ": a grid needs an axis");
  return sweep;
}

PlannedSolver parse_solver(const JsonObject& object) {
  object.only({"solver", "every", "sweep", "sets", "optional"});
  PlannedSolver solver;
  const std::string& spec = object.text("solver");
  solver.spec = located(object, "solver", [&] { return canonical_solver_spec(parse_spec(spec)); });
  if (object.given("every")) solver.every = object.integer("every", 1, kMaxTrials);
  if (object.given("optional")) solver.optional = object.boolean("optional");
  if (object.given("sets")) {
    solver.sets = object.texts("sets");
    if (solver.sets.empty()) object.fail("sets", ": a solver needs a set");
  }
  if (object.given("sweep")) {
    if (object.is_object("sweep")) {
      solver.sweep = parse_sweep(object.inside("sweep"));
    } else {
      const std::string& name = object.text("sweep");
      solver.sweep = located(object, "sweep", [&] { return builtin_sweep(name, solver.spec); });
    }
    located(object, "sweep", [&] { return sweep_cells(*solver.sweep, solver.spec); });
  }
  return solver;
}

Plan parse_fields(const JsonObject& object) {
  object.only({"format", "version", "name", "description", "seed", "trials", "time_limit_s", "repeat_until_s",
               "budget_s", "solved_at", "jobs", "start", "sets", "solvers"});
  if (object.text("format") != kFormat) object.fail("format", fmt::format(": expected '{}'", kFormat));
  object.integer("version", kVersion, kVersion);
  Plan plan;
  plan.name = checked_name(object);
  if (object.given("description")) plan.description = object.text("description");
  if (object.given("seed")) plan.seed = object.unsigned_integer("seed");
  if (object.given("trials")) plan.trials = object.integer("trials", 1, kMaxTrials);
  if (object.given("time_limit_s")) plan.time_limit_s = positive(object, "time_limit_s", kLongestSeconds);
  if (object.given("repeat_until_s")) {
    const bool once = object.number("repeat_until_s") == 0;
    plan.repeat_until_s = once ? 0 : positive(object, "repeat_until_s", kLongestSeconds);
  }
  if (object.given("budget_s")) plan.budget_s = positive(object, "budget_s", kLongestSeconds);
  if (object.given("solved_at")) plan.solved_at = positive(object, "solved_at", 1);
  if (object.given("jobs")) plan.jobs = static_cast<int>(object.integer("jobs", 1, 1024));
  if (object.given("start")) {
    plan.start_last = object.text("start") == "last";
    if (!plan.start_last) object.fail("start", ": expected 'last'");
  }
  for (const JsonObject& set : object.objects("sets")) plan.sets.push_back(parse_set(set));
  for (const JsonObject& solver : object.objects("solvers")) plan.solvers.push_back(parse_solver(solver));
  if (plan.sets.empty()) object.fail("sets", ": a plan needs a set");
  if (plan.solvers.empty()) object.fail("solvers", ": a plan needs a solver");
  return plan;
}

/// Entries of the list `field` that are texts become objects with that text as their field `key`.
void spell_out(Json& plan, const char* field, const char* key) {
  if (!plan.is_object() || !plan.contains(field) || !plan[field].is_array()) return;
  for (Json& entry : plan[field]) {
    if (entry.is_string()) entry = Json{{key, entry}};
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
  Json json = parse_json_document(text, origin);
  spell_out(json, "sets", "set");
  spell_out(json, "solvers", "solver");
  return parse_fields(JsonObject(json, origin));
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
  if (plan.solved_at) json["solved_at"] = *plan.solved_at;
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
  if (!std::filesystem::exists(name_or_file, ignored)) {
    const std::vector<std::string> built_in = builtin_plan_names();
    throw InputError(fmt::format("plan '{}': neither a file nor built in ({}){}", name_or_file,
                                 fmt::join(built_in, ", "), did_you_mean(name_or_file, built_in)));
  }
  return parse_plan(read_text(name_or_file, "plan file"), name_or_file);
}

std::vector<std::string> builtin_plan_names() {
  std::vector<std::string> names;
  for (const BuiltinPlan& plan : kBuiltinPlans) names.emplace_back(plan.name);
  return names;
}

}  // namespace lcpbench
