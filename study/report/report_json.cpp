#include <algorithm>
#include <map>

#include "core/registry.h"
#include "study/paper/records.h"
#include "study/report/model_errors.h"
#include "study/report/report.h"
#include "study/report/sets.h"
#include "study/report/sql_functions.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

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

/// The distinct values that the runs recorded under a name, as an array.
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
  made["version"] = recorded(summary, "lcpbench");
  for (const char* name : {"commit", "processor", "compiler", "flags", "seed", "libraries", "command"}) {
    made[name] = page_value(recorded(summary, name));
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
    const std::optional<SceneName> scene = scene_name(set.name);
    sets.push_back({{"name", set.name},
                    {"family", family_of(set)},
                    {"kind", to_string(kind_of(set))},
                    {"problems", set.problems},
                    {"n_min", set.smallest_n},
                    {"n_max", set.largest_n},
                    {"frictional", set.frictional},
                    {"hard", is_hard_set(set.name)},
                    {"truth", hard_truth(set.name)},
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
    const auto known = std::ranges::find(registered_solvers(), solver.name,
                                         [](const RegisteredSolver& each) { return each.definition.name; });
    const bool here = known != registered_solvers().end();
    solvers.push_back({{"spec", solver.text()},
                       {"label", solver_label(summary, i)},
                       {"name", solver.name},
                       {"settings", solver.settings},
                       {"all_settings", solver.all_settings},
                       {"summary", here ? known->definition.summary : ""},
                       {"source", here ? known->definition.source : ""},
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

/// What the page pools of each solver on each set.
Json statistics_of_cells(const Report& report, const std::map<std::size_t, std::size_t>& places) {
  Json records = Json::array();
  for (const CellStatistics& cell : report.statistics.cells) {
    records.push_back({{"set", cell.set},
                       {"solver", places.at(cell.solver)},
                       {"met", cell.met},
                       {"refused", cell.refused},
                       {"unsolvable", cell.unsolvable},
                       {"crashed", cell.crashed},
                       {"gave_up", cell.gave_up},
                       {"other_model", cell.other_model},
                       {"solved", cell.solved},
                       {"false", cell.wrong},
                       {"time_n", cell.time.n},
                       {"time_log_sum", cell.time.sum},
                       {"time_log_square_sum", cell.time.square_sum},
                       {"error_p99", cell.error_p99},
                       {"profile", cell.profile}});
  }
  return records;
}

/// Each pair of solvers on a set at the first of the errors, and again at each error where its numbers change.
Json statistics_of_pairs(const Report& report, const std::map<std::size_t, std::size_t>& places) {
  Json records = Json::array();
  for (const PairStatistics& pair : report.statistics.pairs) {
    for (std::size_t error = 0; error < kErrors; ++error) {
      const PairStatistics::AtError& at = pair.at[error];
      if (error > 0 && at == pair.at[error - 1]) continue;
      records.push_back({{"set", pair.set},
                         {"a", places.at(pair.a)},
                         {"b", places.at(pair.b)},
                         {"both_took", pair.both_took},
                         {"both_unsolvable", pair.both_unsolvable},
                         {"error", error},
                         {"only_a", at.only_a},
                         {"only_b", at.only_b},
                         {"false_a", at.wrong_a},
                         {"false_b", at.wrong_b},
                         {"n", at.ratio.n},
                         {"log_sum", at.ratio.sum},
                         {"log_square_sum", at.ratio.square_sum}});
    }
  }
  return records;
}

/// The result of a query by columns. Text that begins with '[' is parsed: fill_table() stores arrays as text.
Json columns_of(sqlite::Database& database, const std::string& sql) {
  const QueryResult result = run_query(database, "report.json", sql);
  Json columns = Json::object();
  for (const std::string& name : result.columns) columns[name] = Json::array();
  for (const Json& row : result.rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const bool is_array = row[i].is_string() && row[i].get_ref<const std::string&>().starts_with('[');
      columns[result.columns[i]].push_back(is_array ? Json::parse(row[i].get_ref<const std::string&>()) : row[i]);
    }
  }
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

Json worst_records(const Report& report) {
  const Summary& summary = report.summary;
  Json records = Json::array();
  ReplayCommands commands(summary);
  for (std::size_t i = 0; i < report.worst.size(); ++i) {
    const Cell& cell = summary.cells[i];
    std::int64_t place = 0;
    for (const FailedProblem& failed : report.worst[i]) {
      records.push_back({{"set", summary.sets[cell.set].name},
                         {"solver", solver_label(summary, cell.solver)},
                         {"seed", failed.problem.seed},
                         {"trial", failed.problem.trial},
                         {"claim", failed.claim == Claim::kSolved ? "solved" : "not solved"},
                         {"verdict", failed.failure.false_claim ? "wrong" : "not solved"},
                         {"error", failed.failure.error},
                         {"time_s", failed.time_s},
                         {"command", commands.command(cell, failed)},
                         {"place", ++place}});
    }
  }
  return records;
}

/// The solvers that were compared for each situation, one record for each at each error.
/// @param errors  how many of kErrorGrid, from the first
Json contender_records(const Report& report, std::size_t errors) {
  const Summary& summary = report.summary;
  Json records = Json::array();
  for (const Situation& situation : report.situations) {
    for (std::size_t error = 0; error < errors; ++error) {
      const Choice choice = choose(report.statistics, situation.sets, single_solvers(summary), error);
      for (const Contender& contender : choice.contenders) {
        const bool ranked = contender.ground <= Ground::kBehindTheBest;
        records.push_back({{"contacts", situation.title},
                           {"solver", solver_label(summary, contender.solver)},
                           {"recommended", choice.recommended && &contender == choice.contenders.data()},
                           {"tie", contender.tie},
                           {"reliable", ranked ? Json(contender.reliable()) : Json()},
                           {"reliability", to_string(contender.ground)},
                           {"trials", contender.false_claims.whole},
                           {"solved", share_json(contender.solved)},
                           {"false_claims", share_json(contender.false_claims)},
                           {"refused", share_json(contender.refused)},
                           {"error_p99", contender.error_p99},
                           {"mean_time_s", estimate_json(contender.time)},
                           {"factor", estimate_json(contender.factor.ratio)},
                           {"error", kErrorGrid[error]}});
        records.back()["factor"]["problems"] = contender.factor.problems;
      }
    }
  }
  return records;
}

/// The cells of summary.json without `claims`, with label, refusal and reliability.
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
    records.push_back(std::move(record));
  }
  return records;
}

/// Claim against verdict as records, one per set, solver at single settings and claim.
Json claims_json(const Report& report, const Json& cells) {
  Json records = Json::array();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Json& cell = cells[i];
    if (!cell.contains("claims")) continue;
    for (const auto& [claim, verdicts] : cell["claims"].items()) {
      Json record{{"set", cell["set"]},
                  {"solver", cell["solver"]},
                  {"settings", cell["settings"]},
                  {"sweep", cell["sweep"]},
                  {"claim", claim}};
      record.update(verdicts);
      record["label"] = solver_label(report.summary, report.summary.cells[i].solver);
      records.push_back(std::move(record));
    }
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

/// The records of the temporary tables.
Json table_records(const Report& report) {
  const Json summary = summary_json(report.summary);
  const std::map<std::size_t, std::size_t> places = solver_places(report.summary);
  Json records{{"cells", labelled_cells(report, summary["cells"])},
               {"sweeps", summary["sweeps"]},
               {"claims", claims_json(report, summary["cells"])},
               {"set_facts", sets_json(report)},
               {"solver_facts", solvers_json(report.summary)},
               {"cell_statistics", statistics_of_cells(report, places)},
               {"pair_statistics", statistics_of_pairs(report, places)},
               {"situations", situations_json(report, places)},
               {"contenders", contender_records(report, kErrors)},
               {"worst", worst_records(report)},
               {"rule", Json::array({reliability_rule_json()})},
               {"errors", Json::array()}};
  for (const double error : kErrorGrid) records["errors"].push_back({{"error", error}});
  records.update(paper::paper_records(report.summary));
  return records;
}

/// A report with one item of each kind. Its records give columns to tables that have no rows.
Report one_of_everything() {
  Report one;
  one.summary.sets.resize(1);
  one.summary.sets[0].name = "paper/monotone/exp1";
  one.summary.solvers.resize(2);
  one.summary.solvers[1].sweep = "paper";
  one.summary.cells.resize(2);
  one.summary.cells[1].solver = 1;
  one.statistics.cells = {{.met = 1}};
  one.statistics.pairs.resize(1);
  one.statistics.plans.resize(1);
  one.worst.resize(1, std::vector<FailedProblem>(1));
  one.situations.resize(1);
  one.situations[0].sets = {0};
  return one;
}

}  // namespace

Json report_summary_json(const Report& report) {
  Json json = summary_json(report.summary);
  json["reliability_rule"] = reliability_rule_json();
  json["decision"] = contender_records(report, 1);
  for (Json& record : json["decision"]) record.erase("error");
  return json;
}

Json report_json(Store& store, const Report& report) {
  const Coverage& coverage = report.summary.coverage;
  const auto known = [&coverage](std::int64_t count) { return coverage.known ? Json(count) : Json(); };
  sqlite::Database& database = store.database();
  Json pairs = columns_of(database,
                          "SELECT \"set\", a, b, both_took, COUNT(*) AS rows FROM pair_statistics "
                          "GROUP BY \"set\", a, b ORDER BY \"set\", a, b");
  pairs["at"] = columns_of(database,
                           "SELECT error, only_a, only_b, false_a, false_b, n, log_sum, log_square_sum "
                           "FROM pair_statistics ORDER BY \"set\", a, b, error");
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
          {"cells", columns_of(database, "SELECT *, error_p99 IS 9e999 AS no_number FROM cell_statistics")},
          {"pairs", std::move(pairs)},
          {"situations", situations_json(report, solver_places(report.summary))},
          {"notes", notes(report.summary)},
          {"tables", Json::array()},
          {"paper", {{"tables", Json::array()}, {"claims", Json::array()}}},
          {"comparison", nullptr},
          {"scenes", Json::array()},
          {"replays", Json::array()}};
}

void fill_tables(Store& store, const Report& report, const std::vector<std::string>& named) {
  sqlite::Database& database = store.database();
  const sqlite::ReadSnapshot snapshot(database);
  add_statistics_functions(database);
  const std::vector<std::string> drops = database.texts(
      "SELECT printf('DROP %s temp.\"%w\"', type, name) FROM sqlite_temp_master WHERE type IN ('table', 'view')");
  for (const std::string& drop : drops) database.execute(drop);  // of an earlier call
  const Json records = table_records(report);
  const Json examples = table_records(one_of_everything());
  for (const auto& [name, table] : records.items()) fill_table(database, name, table, examples[name][0]);
  report.regrets.fill_table(database);
  Json labels = Json::array();
  for (const std::string& solver : named) {
    for (const std::size_t i : single_solvers(report.summary)) {
      if (report.summary.solvers[i].text() == solver) labels.push_back({{"solver", solver_label(report.summary, i)}});
    }
  }
  fill_table(database, "named", labels, {{"solver", ""}});
  database.execute(std::string(kViews));
  database.execute(std::string(paper::kQueries));
}

void fill_slow_tables(Store& store, const Summary& summary, const std::vector<ReplayedFiles>& replays) {
  std::vector<ReplayedFiles> one_replay(1);
  one_replay[0].scene.replays.resize(1);
  fill_table(store.database(), "replay", replay_records(replays), replay_records(one_replay)[0]);
  fill_table(store.database(), "model_errors", model_errors(store, summary),
             {{"set", ""}, {"trial", 0}, {"relaxation_m_per_s", 0}, {"softness_m_per_s", 0}});
}

}  // namespace lcpbench::report
