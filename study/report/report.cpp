#include "study/report/report.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "core/error.h"
#include "study/report/solver_comparison.h"
#include "study/report/canvas.h"
#include "study/report/comparison_tables.h"
#include "study/report/conditioning.h"
#include "study/report/csv.h"
#include "study/report/decision.h"
#include "study/report/ecdf_figures.h"
#include "study/report/figures.h"
#include "study/report/hard.h"
#include "study/report/page.h"
#include "study/report/paper.h"
#include "study/report/text.h"

namespace lcpbench {

namespace {

using Json = nlohmann::ordered_json;

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(folder.string() + ": cannot make the folder: " + error.message());
}

void write_file(const std::filesystem::path& file, const std::string& content) {
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out << content;
  out.close();
  if (!out) throw InputError(file.string() + ": cannot write: " + std::strerror(errno));
}

std::string json_document(const Json& json) { return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"; }

Json share_json(const report::Share& share) {
  return {{"count", share.part},
          {"of", share.whole},
          {"share", share.value()},
          {"low", share.interval().low},
          {"high", share.interval().high}};
}

Json estimate_json(const Estimate& estimate) {
  return {{"value", estimate.value}, {"low", estimate.low}, {"high", estimate.high}};
}

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
                         {"solved", share_json(contender.solved)},
                         {"false_claims", share_json(contender.false_claims)},
                         {"refused", share_json(contender.refused)},
                         {"error_median", contender.median_error},
                         {"error_p99", contender.p99_error},
                         {"median_time_s", estimate_json(contender.time)},
                         {"speedup", estimate_json(contender.speedup)}});
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

/// A summary with one of everything: its records have the names of every table's columns.
Summary example_summary() {
  Summary example;
  example.sets.resize(1);
  example.solvers.resize(1);
  example.cells.resize(1);
  example.sweeps.resize(1);
  return example;
}

void write_tables(const Summary& summary, const Json& document, const std::vector<report::Situation>& situations,
                  const std::filesystem::path& folder) {
  make_folder(folder);
  const Summary example = example_summary();
  const Json examples = summary_json(example);
  report::Situation situation;
  situation.contenders.resize(1);
  const auto write = [&folder](const char* name, const Json& example_records, const Json& records) {
    write_file(folder / name, report::csv_table(example_records.at(0), records));
  };
  write("cells.csv", examples["cells"], document["cells"]);
  write("sweeps.csv", examples["sweeps"], document["sweeps"]);
  write("claims.csv", claims_json(examples["cells"]), claims_json(document["cells"]));
  write("decision.csv", decision_json(example, {situation}), decision_json(summary, situations));
}

/// hard_matrix.csv, hard_cases.csv and, where a dial has more than one value, hard_dials.csv.
void write_hard_tables(const Summary& summary, const std::filesystem::path& folder) {
  const Json tables = report::hard_tables(summary, report::hard_study(summary));
  for (const auto& [name, records] : tables.items()) {
    if (!records.empty()) write_file(folder / (name + ".csv"), report::csv_table(records.at(0), records));
  }
}

/// mcnemar.csv, solver_times.csv, ecdf.csv, profiles.csv, vbs.csv, chains.csv.
void write_comparison_tables(const Summary& summary, const std::vector<SetComparison>& comparisons,
                             const std::filesystem::path& folder) {
  make_folder(folder);
  const Json examples = report::comparison_tables(example_summary(), {report::example_comparison()});
  const Json tables = report::comparison_tables(summary, comparisons);
  for (const auto& [name, records] : tables.items()) {
    write_file(folder / (name + ".csv"), report::csv_table(examples[name].at(0), records));
  }
}

/// speed_error.csv, cheapest.csv and, where the store has sets along a dial, conditioning.csv.
void write_speed_error_tables(const Json& tables, const std::filesystem::path& folder) {
  for (const auto& [name, records] : tables.items()) {
    if (!records.empty()) write_file(folder / (name + ".csv"), report::csv_table(records.at(0), records));
  }
}

Json speed_error_tables(const Summary& summary, const report::SpeedErrorStudy& study) {
  return {{"speed_error", report::speed_error_json(summary, study.sets)},
          {"cheapest", report::cheapest_json(summary, study.sets)},
          {"conditioning", report::conditioning_json(summary, study.families)}};
}

report::Figures draw_figures(const Summary& summary, const std::vector<SetComparison>& comparisons,
                             const report::SpeedErrorStudy& study) {
  report::Figures figures;
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
  return figures;
}

/// File names of sets, made unique: different names may differ only in characters that file names do without.
class FileNames {
 public:
  std::string unique(const std::string& set, const std::string& ending) {
    const std::string stem = report::file_stem(set);
    std::string name = stem + ending;
    for (int suffix = 2; !taken_.insert(name).second; ++suffix) name = fmt::format("{}-{}{}", stem, suffix, ending);
    return "figures/" + name;
  }

 private:
  std::set<std::string> taken_;
};

/// Gives every figure its place, and writes it there.
void write_figures(const Summary& summary, const report::SpeedErrorStudy& study, report::Figures& figures,
                   const std::filesystem::path& folder) {
  make_folder(folder / "figures");
  FileNames names;
  const auto write = [&](std::map<std::size_t, report::Figure>& kind, const char* ending, const auto& name) {
    for (auto& [index, figure] : kind) {
      figure.file = names.unique(name(index), ending);
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
  const std::optional<std::size_t> headline = report::headline_set(summary);
  const auto figure = headline ? figures.speed_error.find(*headline) : figures.speed_error.end();
  if (figure != figures.speed_error.end()) write_file(folder / names.unique("headline", ".svg"), figure->second.svg);
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
  for (const Cell& cell : summary.cells) {
    const SolverRow& solver = summary.solvers[cell.solver];
    if (!solver.sweep.empty()) continue;
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
                       {"error_median", cell.error_median},
                       {"error_p99", cell.error_p99},
                       {"reliability", standing[&cell]}});
  }
  return records;
}

}  // namespace

void write_report(Store& store, const std::filesystem::path& folder) {
  const Summary summary = summarize(store);
  const std::vector<report::Situation> situations = report::decide(summary);
  std::vector<SetComparison> comparisons = compare_solvers(summary, report::recommended_by_set(situations));
  // One problem each: there is nothing to test or to draw.
  std::erase_if(comparisons, [&summary](const SetComparison& comparison) {
    return report::is_hard_set(summary.sets[comparison.set].name);
  });
  const report::SpeedErrorStudy speed_error = report::speed_error_study(summary);
  report::Figures figures = draw_figures(summary, comparisons, speed_error);
  Json document = summary_json(summary);
  document["reliability_rule"] = report::reliability_rule_json();
  document["decision"] = decision_json(summary, situations);
  document["comparison"] = report::comparison_json(summary, comparisons);
  const Json speed_error_records = speed_error_tables(summary, speed_error);
  document["speed_against_error"] = speed_error_records;
  make_folder(folder);
  write_tables(summary, document, situations, folder / "tables");
  write_comparison_tables(summary, comparisons, folder / "tables");
  write_hard_tables(summary, folder / "tables");
  write_speed_error_tables(speed_error_records, folder / "tables");
  write_file(folder / "tables" / "results.csv",
             report::csv_table(results_json(example_summary(), {}).at(0), results_json(summary, speed_error)));
  write_figures(summary, speed_error, figures, folder);
  write_file(folder / "summary.json", json_document(document));
  const report::PaperStudy paper = report::paper_study(summary);
  for (const auto& [name, content] : report::paper_files(summary, paper)) write_file(folder / name, content);
  write_file(folder / "report.html", report::html_page(summary, situations, comparisons, speed_error, figures, paper));
}

}  // namespace lcpbench
