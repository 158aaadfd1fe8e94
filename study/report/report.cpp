#include "study/report/report.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "core/error.h"
#include "core/io/whole_file.h"
#include "study/output/csv.h"
#include "study/report/canvas.h"
#include "study/report/decision.h"
#include "study/report/figures.h"
#include "study/report/hard.h"
#include "study/report/page.h"
#include "study/report/paper.h"
#include "study/report/regret.h"
#include "study/report/scenes.h"
#include "study/report/solver_comparison.h"
#include "study/report/speed_error.h"
#include "study/report/tables.h"
#include "study/report/text.h"
#include "study/report/worst.h"

namespace lcpbench {

namespace {

using Json = nlohmann::ordered_json;
using report::Report;

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(folder.string() + ": cannot make the folder: " + error.message());
}

std::string json_document(const Json& json) { return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"; }

/// The decision table as records, one per situation and solver.
Json decision_json(const Summary& summary, const std::vector<report::Situation>& situations) {
  Json records = Json::array();
  for (const report::Situation& situation : situations) {
    for (std::size_t i = 0; i < situation.contenders.size(); ++i) {
      const report::Contender& contender = situation.contenders[i];
      records.push_back({{"contacts", situation.title},
                         {"solver", summary.solvers[contender.solver].text()},
                         {"recommended", situation.recommended == i},
                         {"tie", contender.tie},
                         {"why_not", contender.verdict},
                         {"reliable", report::reliable_json(contender.reliability)},
                         {"reliability", report::to_string(contender.reliability.ground)},
                         {"trials", contender.trials},
                         {"solved", report::share_json(contender.solved)},
                         {"solved_of_met", report::share_json(contender.solved_of_met)},
                         {"false_claims", report::share_json(contender.false_claims)},
                         {"refused", report::share_json(contender.refused)},
                         {"error_median", contender.median_error},
                         {"error_p99", contender.p99_error},
                         {"median_time_s", report::estimate_json(contender.time)},
                         {"speedup", report::estimate_json(contender.speedup.ratio)}});
      records.back()["speedup"]["problems"] = contender.speedup.problems;
    }
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

report::Figures draw_figures(const Summary& summary, const std::vector<SetComparison>& comparisons,
                             const report::SpeedErrorStudy& study, const report::ModelErrors& model_errors) {
  report::Figures figures;
  if (auto figure = report::model_error_figure(summary, model_errors)) figures.model_error[0] = std::move(*figure);
  for (const report::SpeedError& set : study.sets) {
    if (study.is_step(summary, set.set)) continue;
    if (auto figure = report::speed_error_figure(summary, set)) figures.speed_error[set.set] = std::move(*figure);
  }
  for (std::size_t i = 0; i < study.families.size(); ++i) {
    auto figure = report::conditioning_figure(summary, study.families[i]);
    if (figure) figures.conditioning[i] = std::move(*figure);
  }
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    if (report::is_hard_set(summary.sets[set].name)) continue;
    if (auto figure = report::error_distribution_figure(summary, set)) figures.distribution[set] = std::move(*figure);
  }
  for (const SetComparison& comparison : comparisons) {
    const std::size_t set = comparison.set;
    if (auto figure = report::time_ecdf_figure(summary, comparison)) figures.time_ecdf[set] = std::move(*figure);
    if (auto figure = report::error_ecdf_figure(summary, comparison)) figures.error_ecdf[set] = std::move(*figure);
  }
  for (const report::SceneFamily& family : report::scene_families(summary)) {
    for (const std::size_t set : family.sets) {
      auto figure = report::scene_picture(summary.sets[set].name);
      if (!figure) continue;
      figures.scene[set] = std::move(*figure);
      break;
    }
  }
  return figures;
}

/// Gives every figure its place, and writes it there.
void write_figures(const Summary& summary, const report::SpeedErrorStudy& study, report::Figures& figures,
                   const std::filesystem::path& folder) {
  make_folder(folder / "figures");
  std::set<std::string> names;
  const auto write = [&](std::map<std::size_t, report::Figure>& kind, const char* ending, const auto& name) {
    for (auto& [index, figure] : kind) {
      figure.file = report::figure_file(report::file_stem(name(index)), ending, names);
      write_file(folder / figure.file, figure.svg);
    }
  };
  const auto family = [&study](std::size_t index) { return study.families[index].family; };
  const auto set_name = [&summary](std::size_t set) { return summary.sets[set].name; };
  write(figures.conditioning, ".conditioning.svg", family);
  write(figures.speed_error, ".svg", set_name);
  write(figures.distribution, ".errors.svg", set_name);
  write(figures.time_ecdf, ".ecdf-time.svg", set_name);
  write(figures.error_ecdf, ".ecdf-error.svg", set_name);
  write(figures.scene, ".scene.svg", set_name);
  write(figures.model_error, ".model-error.svg", [](std::size_t) { return "scenes"; });
  const std::optional<std::size_t> headline = report::headline_set(summary);
  const auto figure = headline ? figures.speed_error.find(*headline) : figures.speed_error.end();
  if (figure != figures.speed_error.end()) {
    write_file(folder / report::figure_file("headline", ".svg", names), figure->second.svg);
  }
}

/// One row per set and solver at single settings, the columns that most readers want, each named with its unit.
/// @param study  of the summary: gives the standing
Json results_json(const Summary& summary, const report::SpeedErrorStudy& study) {
  std::map<const Cell*, std::string> standing;
  for (const report::SpeedError& set : study.sets) {
    for (const report::SpeedErrorPoint& point : set.points) {
      standing[point.cell] = report::to_string(point.reliability.ground);
    }
  }
  Json records = Json::array();
  report::ReplayCommands replay(summary);
  for (const Cell& cell : summary.cells) {
    const SolverRow& solver = summary.solvers[cell.solver];
    if (!solver.sweep.empty()) continue;
    const Outcome* const worst = report::worst_outcome(cell);
    records.push_back({{"set", summary.sets[cell.set].name},
                       {"solver", solver_label(summary, cell.solver)},
                       {"library", solver.library},
                       {"problems", cell.trials},
                       {"solved_share", cell.rate()},
                       {"solved_share_low", cell.rate_interval.low},
                       {"solved_share_high", cell.rate_interval.high},
                       {"false_claims", cell.false_claims()},
                       {"gave_up", cell.gave_up()},
                       {"refused", cell.count(Claim::kUnsupported)},
                       {"median_time_s", cell.median_time.value},
                       {"median_time_low_s", cell.median_time.low},
                       {"median_time_high_s", cell.median_time.high},
                       {"time_ratio", cell.time_ratio.value},
                       {"time_ratio_low", cell.time_ratio.low},
                       {"time_ratio_high", cell.time_ratio.high},
                       {"time_ratio_problems", cell.paired},
                       {"error_median", cell.error_median},
                       {"error_p99", cell.error_p99},
                       {"reliability", standing[&cell]},
                       {"model", to_string(solver.friction)},
                       {"solver_error_median_m_per_s", cell.solver_error.median},
                       {"model_error_median_m_per_s", cell.model_error.median},
                       {"worst_trial", worst == nullptr ? Json() : Json(worst->trial)},
                       {"worst_replay", worst == nullptr ? "" : replay.command(cell, *worst)}});
  }
  return records;
}

/// The content of summary.json.
Json report_json(const Report& report) {
  Json json = summary_json(report.summary);
  json["reliability_rule"] = report::reliability_rule_json();
  json["decision"] = decision_json(report.summary, report.situations);
  json["comparison"] = report::comparison_json(report.summary, report.comparisons);
  json["speed_against_error"] = {
      {"speed_error", report::speed_error_json(report.summary, report.speed_error.sets)},
      {"cheapest", report::cheapest_json(report.summary, report.speed_error.sets)},
      {"conditioning", report::conditioning_json(report.summary, report.speed_error.families)}};
  json["models"] = report::model_choices_json(report.summary, report.model_choices);
  json["regret"] = report::regret_summary_json(report.regret);
  for (const ReplayPictures& replay : report.replays) json["replay"].push_back(replay_json(replay.scene));
  return json;
}

/// The records of every table by the name of its file. @param json  of report_json()
Json table_records(const Report& report, const Json& json) {
  Json tables = report::comparison_tables(report.summary, report.comparisons);
  tables.update(report::hard_tables(report.summary, report::hard_study(report.summary)));
  tables.update(json["speed_against_error"]);
  tables["velocity_spread"] = report::velocity_spread_json(report.summary, report.velocity_spreads);
  tables["model_choice"] = report::model_choice_json(report.summary, report.model_choices.steps);
  tables["regret"] = report::regret_json(report.summary, report.regret.regrets);
  for (const char* name : {"cells", "sweeps", "decision"}) tables[name] = json[name];
  tables["claims"] = claims_json(json["cells"]);
  tables["results"] = results_json(report.summary, report.speed_error);
  return tables;
}

/// The tables of hard cases and of speed against error are left out where the store has nothing for them; the others
/// have their headings even then.
void write_tables(const Report& report, const Json& json, const std::filesystem::path& folder) {
  Report one_of_everything;
  one_of_everything.summary.sets.resize(1);
  one_of_everything.summary.solvers.resize(1);
  one_of_everything.summary.cells.resize(1);
  one_of_everything.summary.sweeps.resize(1);
  one_of_everything.situations.resize(1);
  one_of_everything.situations[0].contenders.resize(1);
  one_of_everything.velocity_spreads.resize(1);
  one_of_everything.model_choices.steps.resize(1);
  one_of_everything.regret.regrets.resize(1);
  one_of_everything.comparisons = {report::example_comparison()};
  const Json examples = table_records(one_of_everything, report_json(one_of_everything));
  const Json tables = table_records(report, json);
  make_folder(folder);
  for (const auto& [name, records] : tables.items()) {
    const Json& columns = examples[name].empty() ? records : examples[name];
    if (!columns.empty()) write_file(folder / (name + ".csv"), csv_table(columns.at(0), records));
  }
  if (report.replays.empty()) return;
  std::vector<ReplayedScene> replayed;
  for (const ReplayPictures& replay : report.replays) replayed.push_back(replay.scene);
  write_file(folder / "replay.csv", replay_summary_csv(replayed));
}

Report make_report(Store& store, const std::vector<ReplayedFiles>& replays) {
  Report report;
  report.replays = pictures_of(replays);
  report.summary = summarize(store);
  const Summary& summary = report.summary;
  report.situations = report::decide(summary);
  report.comparisons = compare_solvers(summary, report::recommended_by_set(report.situations));
  // One problem each: there is nothing to test or to draw.
  std::erase_if(report.comparisons, [&summary](const SetComparison& comparison) {
    return report::is_hard_set(summary.sets[comparison.set].name);
  });
  report.speed_error = report::speed_error_study(summary);
  report.velocity_spreads = report::velocity_spreads(store, summary);
  report.model_errors = report::model_errors(summary);
  report.model_choices = report::model_choices(summary);
  report.regret = report::regret_study(store, summary);
  report.figures = draw_figures(summary, report.comparisons, report.speed_error, report.model_errors);
  report.paper = report::paper_study(summary);
  return report;
}

}  // namespace

void write_report(Store& store, const std::filesystem::path& folder, const std::vector<ReplayedFiles>& replays) {
  Report report = make_report(store, replays);
  const Json json = report_json(report);
  make_folder(folder);
  WholeFile page(folder / "report.html");  // its lock keeps another report out of the folder
  write_tables(report, json, folder / "tables");
  write_figures(report.summary, report.speed_error, report.figures, folder);
  write_file(folder / "summary.json", json_document(json));
  for (const auto& [name, content] : report::paper_files(report.summary, report.paper)) {
    write_file(folder / name, content);
  }
  page.write(report::html_page(report));
  page.commit();
}

}  // namespace lcpbench
