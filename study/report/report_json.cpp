#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>

#include <fmt/format.h>

#include "study/paper/records.h"
#include "study/report/hard.h"
#include "study/report/model_errors.h"
#include "study/report/report.h"
#include "study/report/sets.h"
#include "study/report/sql_functions.h"
#include "study/report/velocity_spread.h"
#include "study/report/worst.h"

namespace lcpbench::report {

namespace {

using Json = nlohmann::ordered_json;

Json share_json(const Share& share) {
  const Interval interval = share.interval();
  return {{"part", share.part},
          {"whole", share.whole},
          {"share", share.value()},
          {"low", interval.low},
          {"high", interval.high}};
}

Json estimate_json(const Estimate& estimate) {
  return {{"value", estimate.value}, {"low", estimate.low}, {"high", estimate.high}};
}

/// What the runs recorded under a name; an array of the distinct values.
Json recorded(const Summary& summary, const char* name) {
  Json values = Json::array();
  for (const RunSummary& run : summary.runs) {
    if (!run.provenance.is_object() || !run.provenance.contains(name)) continue;
    const Json& value = run.provenance[name];
    if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
  }
  return values;
}

Json made_json(const Summary& summary) {
  Json made = Json::object();
  for (const char* name : {"version", "commit", "processor", "compiler", "flags", "seed", "libraries", "command"}) {
    made[name] = recorded(summary, name);
  }
  made["started"] = Json::array();
  for (const RunSummary& run : summary.runs) made["started"].push_back(run.started);
  made["reference"] = summary.reference.empty() ? Json() : Json(summary.reference);
  return made;
}

Json sets_json(const Report& report) {
  Json sets = Json::array();
  for (std::size_t i = 0; i < report.summary.sets.size(); ++i) {
    const SetSummary& set = report.summary.sets[i];
    const SetPlan& plan = report.statistics.plans[i];
    const std::optional<ConditionDial> dial = condition_dial(set.name);
    const std::optional<SceneName> scene = scene_name(set.name);
      sets.push_back({{"name", set.name},
                    {"family", family_of(set)},
                    {"kind", to_string(kind_of(set))},
                    {"title", describe(set)},
                    {"problems", set.problems},
                    {"n_min", set.smallest_n},
                    {"n_max", set.largest_n},
                    {"frictional", set.frictional},
                    {"hard", is_hard_set(set.name)},
                    {"dial", dial ? Json(dial->condition) : Json()},
                    {"engine", scene ? Json(scene->engine) : Json()},
                    {"all_solvable", set.all_solvable},
                    {"nearly", set.nearly},
                    {"planned", report.summary.coverage.known ? Json(plan.planned) : Json()},
                    {"done", report.summary.coverage.known ? Json(plan.done) : Json()}});
  }
  return sets;
}

Json solvers_json(const Summary& summary) {
  Json solvers = Json::array();
  for (std::size_t i = 0; i < summary.solvers.size(); ++i) {
    const SolverRow& solver = summary.solvers[i];
    if (!solver.sweep.empty()) continue;
    solvers.push_back({{"spec", solver.text()},
                       {"label", solver_label(summary, i)},
                       {"name", solver.name},
                       {"settings", solver.settings},
                       {"all_settings", solver.all_settings},
                       {"library", solver.library},
                       {"version", solver.version},
                       {"isa", solver.isa},
                       {"model", to_string(solver.friction)}});
  }
  return solvers;
}

/// report.json has the solvers at single settings alone: their places in its list.
std::map<std::size_t, std::size_t> solver_places(const Summary& summary) {
  std::map<std::size_t, std::size_t> places;
  for (const std::size_t solver : single_solvers(summary)) places.emplace(solver, places.size());
  return places;
}

/// One column for each member of the records, which all have the same ones.
Json columns_of(const Json& records, const Json& example) {
  Json columns = Json::object();
  for (const auto& [name, value] : example.items()) columns[name] = Json::array();
  for (const Json& record : records) {
    for (const auto& [name, value] : record.items()) columns[name].push_back(value);
  }
  return columns;
}

Json cell_json(const Cell& cell, const CellStatistics& statistics, std::size_t place) {
  return {{"set", cell.set},
          {"solver", place},
          {"met", statistics.met},
          {"refused", statistics.refused},
          {"unsolvable", statistics.unsolvable},
          {"crashed", statistics.crashed},
          {"gave_up", statistics.gave_up},
          {"other_model", statistics.other_model},
          {"solved", statistics.solved},
          {"false", statistics.wrong},
          {"time_n", statistics.time.n},
          {"time_log_sum", statistics.time.sum},
          {"time_log_square_sum", statistics.time.square_sum},
          {"time_median_s", cell.median_time.value},
          {"error_median", cell.error_median},
          {"error_p99", cell.error_p99},
          {"refusal", cell.refusal}};
}

Json cells_json(const Report& report, const std::map<std::size_t, std::size_t>& places) {
  Json records = Json::array();
  for (const Cell& cell : report.summary.cells) {
    const auto place = places.find(cell.solver);
    if (place == places.end()) continue;
    const CellStatistics* of = report.statistics.cell(cell.set, cell.solver);
    const CellStatistics refused{.met = cell.trials, .refused = cell.trials};
    records.push_back(cell_json(cell, of == nullptr ? refused : *of, place->second));
  }
  return columns_of(records, cell_json({}, {}, 0));
}

/// For each pair its numbers at the first of the errors, and again at each error where they are others.
Json pairs_json(const Report& report, std::map<std::size_t, std::size_t>& places) {
  const auto at_json = [](std::size_t error, const PairStatistics::AtError& at) {
    return Json{{"error", error},         {"only_a", at.only_a},   {"only_b", at.only_b},
                {"false_a", at.wrong_a},  {"false_b", at.wrong_b}, {"n", at.ratio.n},
                {"log_sum", at.ratio.sum}, {"log_square_sum", at.ratio.square_sum}};
  };
  Json pairs = Json::array();
  Json rows = Json::array();
  for (const PairStatistics& pair : report.statistics.pairs) {
    const std::size_t first = rows.size();
    for (std::size_t error = 0; error < kErrors; ++error) {
      if (error == 0 || pair.at[error] != pair.at[error - 1]) rows.push_back(at_json(error, pair.at[error]));
    }
    pairs.push_back({{"set", pair.set},
                     {"a", places[pair.a]},
                     {"b", places[pair.b]},
                     {"both_took", pair.both_took},
                     {"rows", rows.size() - first}});
  }
  Json columns = columns_of(pairs, {{"set", 0}, {"a", 0}, {"b", 0}, {"both_took", 0}, {"rows", 0}});
  columns["at"] = columns_of(rows, at_json(0, {}));
  return columns;
}

Json situations_json(const Report& report, const std::map<std::size_t, std::size_t>& places) {
  Json situations = Json::array();
  for (const Situation& situation : report.situations) {
    const Contender* recommended = situation.recommended();
    situations.push_back({{"title", situation.title},
                          {"sets", situation.sets},
                          {"error", 0},
                          {"plan_share", situation.choice.plan_share},
                          {"recommended", recommended == nullptr ? Json() : Json(places.at(recommended->solver))},
                          {"withheld", situation.withheld.empty() ? Json() : Json(situation.withheld)}});
  }
  return situations;
}

Json caught_json(const Report& report, const std::map<std::size_t, std::size_t>& places) {
  Json caught = Json::array();
  for (const auto& [solver, share] : caught_solvers(report.summary)) {
    for (const Cell& cell : report.summary.cells) {
      if (cell.solver != solver || cell.false_claims() == 0) continue;
      caught.push_back({{"solver", places.at(solver)},
                        {"set", cell.set},
                        {"false", cell.false_claims()},
                        {"of", cell.trials - cell.count(Claim::kUnsupported)}});
    }
  }
  return caught;
}

/// @param names  sets and solvers by name instead of by place
Json worst_json(const Report& report, const std::map<std::size_t, std::size_t>& places, bool names) {
  const Summary& summary = report.summary;
  Json worst = Json::array();
  ReplayCommands commands(summary);
  const auto shown = [names](double value) {  // four digits in the page, all in the table
    return names ? value : std::strtod(fmt::format("{:.4g}", value).c_str(), nullptr);
  };
  for (std::size_t i = 0; i < report.worst.size(); ++i) {
    const Cell& cell = summary.cells[i];
    std::int64_t place = 0;
    for (const Outcome& outcome : report.worst[i]) {
      worst.push_back({{"set", names ? Json(summary.sets[cell.set].name) : Json(cell.set)},
                       {"solver", names ? Json(solver_label(summary, cell.solver)) : Json(places.at(cell.solver))},
                       {"seed", outcome.seed},
                       {"trial", outcome.trial},
                       {"claim", outcome.claimed ? "solved" : "not solved"},
                       {"verdict", outcome.false_claim ? "wrong" : "not solved"},
                       {"error", shown(outcome.error)},
                       {"time_s", shown(outcome.time_s)},
                       {"command", commands.command(cell, outcome)}});
      if (names) worst.back()["place"] = ++place;
    }
  }
  return worst;
}

/// The decision table as records, one per situation and solver.
Json decision_json(const Report& report) {
  const Summary& summary = report.summary;
  Json records = Json::array();
  for (const Situation& situation : report.situations) {
    for (const Contender& contender : situation.choice.contenders) {
      const PooledErrors errors = pooled_errors(summary, situation.sets, contender.solver);
      Json record{{"contacts", situation.title},
                  {"solver", summary.solvers[contender.solver].text()},
                  {"recommended", &contender == situation.recommended()},
                  {"tie", contender.tie},
                  {"reliable", contender.reliable()},
                  {"reliability", to_string(contender.ground)},
                  {"trials", contender.false_claims.whole},
                  {"solved", share_json(contender.solved)},
                  {"false_claims", share_json(contender.false_claims)},
                  {"refused", share_json(contender.refused)},
                  {"error_median", errors.median},
                  {"error_p99", errors.p99},
                  {"mean_time_s", estimate_json(contender.time)},
                  {"factor", estimate_json(contender.factor.ratio)}};
      if (contender.ground > Ground::kBehindTheBest) record["reliable"] = nullptr;
      record["factor"]["problems"] = contender.factor.problems;
      records.push_back(std::move(record));
    }
  }
  return records;
}

/// Which solver choose() takes for each situation at each error.
Json choices_json(const Report& report) {
  const Summary& summary = report.summary;
  Json records = Json::array();
  for (const Situation& situation : report.situations) {
    for (std::size_t error = 0; error < kErrors; ++error) {
      const Choice choice = choose(report.statistics, situation.sets, single_solvers(summary), error);
      for (const Contender& contender : choice.contenders) {
        records.push_back({{"contacts", situation.title},
                           {"error", kErrorGrid[error]},
                           {"solver", solver_label(summary, contender.solver)},
                           {"recommended", choice.recommended && &contender == choice.contenders.data()},
                           {"reliability", to_string(contender.ground)},
                           {"solved", contender.solved.part},
                           {"of", contender.solved.whole},
                           {"mean_time_s", contender.time.value},
                           {"factor", contender.factor.shown() ? contender.factor.ratio.value : kNoNumber},
                           {"factor_problems", contender.factor.problems}});
      }
    }
  }
  return records;
}

/// The cells of summary.json with what a reader selects them by.
Json labelled_cells(const Report& report, const Json& cells) {
  const Summary& summary = report.summary;
  std::map<std::pair<std::size_t, std::size_t>, Ground> grounds;
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    const Choice choice = choose(report.statistics, {set}, single_solvers(summary), 0);
    for (const Contender& contender : choice.contenders) grounds[{set, contender.solver}] = contender.ground;
  }
  Json records = Json::array();
  for (std::size_t i = 0; i < summary.cells.size(); ++i) {
    Json record = cells[i];
    const Cell& cell = summary.cells[i];
    record.erase("claims");
    const auto ground = grounds.find({cell.set, cell.solver});
    record["label"] = solver_label(summary, cell.solver);
    record["refusal"] = cell.refusal;
    record["reliability"] = ground == grounds.end() ? "" : to_string(ground->second);
    record["time_low_s"] = cell.median_time.low;
    record["time_high_s"] = cell.median_time.high;
    record["hard_outcome"] = is_hard_set(summary.sets[cell.set].name) ? to_string(hard_outcome(cell)) : "";
    record["hard_truth"] = hard_truth(summary.sets[cell.set].name);
    records.push_back(std::move(record));
  }
  return records;
}

/// Claim against verdict as records, one per set, solver at single settings and claim.
Json claims_json(const Json& cells) {
  Json records = Json::array();
  for (const Json& cell : cells) {
    if (!cell.contains("claims")) continue;
    for (const auto& [claim, verdicts] : cell["claims"].items()) {
      Json record{{"set", cell["set"]},
                  {"solver", cell["solver"]},
                  {"settings", cell["settings"]},
                  {"sweep", cell["sweep"]},
                  {"claim", claim}};
      record.update(verdicts);
      records.push_back(std::move(record));
    }
  }
  return records;
}

Json at_errors_json(const Report& report) {
  const Summary& summary = report.summary;
  Json records = Json::array();
  for (const CellStatistics& cell : report.statistics.cells) {
    for (std::size_t error = 0; error < kErrors; ++error) {
      records.push_back({{"set", summary.sets[cell.set].name},
                         {"solver", solver_label(summary, cell.solver)},
                         {"error", kErrorGrid[error]},
                         {"solved", cell.solved[error]},
                         {"wrong", cell.wrong[error]},
                         {"of", cell.taken() - cell.unsolvable},
                         {"taken", cell.taken()},
                         {"mean_time_s", cell.time.geometric_mean().value}});
    }
  }
  return records;
}

Json pair_records(const Report& report) {
  const Summary& summary = report.summary;
  Json records = Json::array();
  for (const PairStatistics& pair : report.statistics.pairs) {
    const PairStatistics::AtError& at = pair.at[0];
    const bool shown = at.ratio.n >= least_problems();
    const Estimate ratio = shown ? at.ratio.geometric_mean() : Estimate{kNoNumber, kNoNumber, kNoNumber};
    records.push_back({{"set", summary.sets[pair.set].name},
                       {"a", solver_label(summary, pair.a)},
                       {"b", solver_label(summary, pair.b)},
                       {"both_took", pair.both_took},
                       {"only_a", at.only_a},
                       {"only_b", at.only_b},
                       {"false_only_a", at.wrong_a},
                       {"false_only_b", at.wrong_b},
                       {"timed", at.ratio.n},
                       {"time_factor", ratio.value},
                       {"time_factor_low", ratio.low},
                       {"time_factor_high", ratio.high}});
  }
  return records;
}

/// One record for each scene and solver.
Json replay_records(const std::vector<ReplayedFiles>& replays) {
  Json records = Json::array();
  for (const ReplayedFiles& files : replays) {
    const ReplayedScene& scene = files.scene;
    const Json rows = replay_json(scene)["replays"];
    for (const Json& row : rows) {
      Json record{{"scene", scene.scene}, {"engine", scene.engine}, {"solver", row["solver"]}, {"steps", scene.steps}};
      record.update(row);
      records.push_back(std::move(record));
    }
  }
  return records;
}

Json unsolvable_json(const Report& report) {
  Json records = Json::array();
  for (const std::int64_t problem : report.summary.unsolvable) records.push_back({{"problem_id", problem}});
  return records;
}

/// The records of every temporary table.
Json table_records(const Report& report, const std::vector<ReplayedFiles>& replays,
                   const Json& spreads) {
  const Json summary = summary_json(report.summary);
  Json records{{"cells", labelled_cells(report, summary["cells"])},
          {"sweeps", summary["sweeps"]},
          {"claims", claims_json(summary["cells"])},
          {"set_facts", sets_json(report)},
          {"decision", decision_json(report)},
          {"choices", choices_json(report)},
          {"at_errors", at_errors_json(report)},
          {"pairs", pair_records(report)},
          {"worst", worst_json(report, solver_places(report.summary), true)},
          {"replay", replay_records(replays)},
          {"unsolvable", unsolvable_json(report)},
          {"velocity_spread", spreads}};
  records.update(paper::paper_records(report.summary));
  return records;
}

/// Its records tell the columns of tables that have no rows.
Report one_of_everything() {
  Report one;
  one.summary.unsolvable.resize(1);
  one.summary.sets.resize(2);
  one.summary.solvers.resize(4);
  one.summary.cells.resize(4);
  one.summary.sets[1].name = "paper/monotone/exp1";
  one.summary.solvers[1] = {.name = "lemke", .all_settings = "pivot_tolerance=1,zero_tolerance=1", .sweep = "paper"};
  one.summary.solvers[2].name = "lemke";
  one.summary.solvers[3].name = "path";
  for (std::size_t i = 1; i < 4; ++i) {
    one.summary.cells[i].set = 1;
    one.summary.cells[i].solver = i;
    if (i > 1) one.summary.cells[i].outcomes.resize(1);
  }
  one.summary.sweeps.resize(1);
  one.statistics.cells.resize(1);
  one.statistics.pairs.resize(1);
  one.statistics.plans.resize(2);
  one.statistics.index();
  one.worst.resize(2, std::vector<Outcome>(1));
  one.situations.resize(1);
  one.situations[0].sets = {0};
  one.situations[0].choice.contenders.resize(1);
  return one;
}

}  // namespace

Json report_summary_json(const Report& report) {
  Json json = summary_json(report.summary);
  json["reliability_rule"] = reliability_rule_json();
  json["decision"] = decision_json(report);
  return json;
}

Json report_json(const Report& report) {
  const Coverage& coverage = report.summary.coverage;
  std::map<std::size_t, std::size_t> places = solver_places(report.summary);
  const auto known = [&coverage](std::int64_t count) { return coverage.known ? Json(count) : Json(); };
  return {{"format", "lcpbench-report"},
          {"version", 1},
          {"kind", "report"},
          {"made", made_json(report.summary)},
          {"plan",
           {{"cells_planned", known(coverage.planned)},
            {"cells_done", known(coverage.done)},
            {"share", coverage.share()},
            {"left_out", coverage.left_out}}},
          {"rule", reliability_rule_json()},
          {"errors", kErrorGrid},
          {"sets", sets_json(report)},
          {"solvers", solvers_json(report.summary)},
          {"cells", cells_json(report, places)},
          {"pairs", pairs_json(report, places)},
          {"situations", situations_json(report, places)},
          {"caught", caught_json(report, places)},
          {"notes", notes(report.summary)},
          {"worst", worst_json(report, places, false)},
          {"tables", Json::array()},
          {"paper", {{"tables", Json::array()}, {"claims", Json::array()}}},
          {"comparison", nullptr},
          {"scenes", Json::array()},
          {"replays", Json::array()}};
}

void fill_tables(Store& store, const Report& report, const std::vector<ReplayedFiles>& replays) {
  sqlite::Database& database = store.database();
  add_statistics_functions(database);
  const Json records = table_records(report, replays, velocity_spreads(store, report.summary));
  std::vector<ReplayedFiles> one_replay(1);
  one_replay[0].scene.replays.resize(1);
  const Json examples = table_records(one_of_everything(), one_replay, Json::array({velocity_spread_example()}));
  for (const auto& [name, table] : records.items()) {
    fill_table(database, name, table, examples[name].empty() ? Json::object() : examples[name][0]);
  }
  fill_table(database, "model_errors", model_errors(store, report.summary),
             {{"set", ""}, {"trial", 0}, {"relaxation_m_per_s", 0}, {"softness_m_per_s", 0}});
  database.execute(std::string(paper::kClaims));
}

}  // namespace lcpbench::report
