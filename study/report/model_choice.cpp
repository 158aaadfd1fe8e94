#include "study/report/model_choice.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "study/models/ladder.h"
#include "study/report/reliability.h"
#include "study/report/scenes.h"
#include "study/report/text.h"
#include "study/statistics/statistics.h"

namespace lcpbench::report {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostMisses = 20;

using StepName = std::pair<std::size_t, std::int64_t>;  // set and trial

/// The store's solvers of the models that are climbed, kNone for one that it lacks.
std::vector<std::size_t> climbed_solvers(const Summary& summary) {
  std::vector<std::size_t> solvers;
  for (const Rung rung : kClimbed) {
    const std::string text = solver_of(rung, kStatedModelError).text();
    const auto found = std::find_if(summary.solvers.begin(), summary.solvers.end(), [&](const SolverRow& solver) {
      return solver.sweep.empty() && solver.text() == text;
    });
    solvers.push_back(found == summary.solvers.end() ? ModelChoice::kNone
                                                     : static_cast<std::size_t>(found - summary.solvers.begin()));
  }
  return solvers;
}

/// Climbs one step. @param by_solver  its outcomes, nullptr where a solver has none
ModelChoice choose(const std::vector<std::size_t>& solvers, const std::vector<const Outcome*>& by_solver) {
  ModelChoice choice;
  for (std::size_t i = 0; i < solvers.size() && !choice.met; ++i) {
    const Outcome* const outcome = by_solver[i];
    if (outcome == nullptr) continue;
    if (i == 0) choice.coarsest_s = outcome->time_s;
    choice.spent_s += outcome->time_s;
    const double error = outcome->model_error_m_per_s;
    if (std::isnan(error) || choice.error_m_per_s <= error) continue;
    choice.solver = solvers[i];
    choice.error_m_per_s = error;
    choice.time_s = outcome->time_s;
    choice.met = error <= kStatedModelError;
  }
  return choice;
}

std::string address(const Summary& summary, const ModelChoice& step) {
  return fmt::format("{}#{}", summary.sets[step.set].name, step.trial);
}

std::string count_cell(std::int64_t count, std::int64_t of) {
  const double share = of > 0 ? static_cast<double>(count) / static_cast<double>(of) : kNoNumber;
  return number_cell(share, std::to_string(count));
}

std::string family_row(const std::string& name, const ModelChoices& of) {
  const auto steps = static_cast<std::int64_t>(of.steps.size());
  const double share = static_cast<double>(of.met()) / static_cast<double>(steps);
  std::string row = "<tr><th scope=\"row\">" + escape(name) + "</th>" +
                    number_cell(static_cast<double>(steps), std::to_string(steps)) +
                    number_cell(share, fmt::format("{} of {}", of.met(), steps));
  for (const std::size_t solver : of.solvers) row += count_cell(of.chosen(solver), steps);
  return row + "</tr>\n";
}

std::string families_table(const Summary& summary, const ModelChoices& choices) {
  std::string rows;
  for (const SceneFamily& family : scene_families(summary)) {
    ModelChoices part{choices.solvers, {}, 0};
    std::copy_if(choices.steps.begin(), choices.steps.end(), std::back_inserter(part.steps), [&](const auto& step) {
      return std::find(family.sets.begin(), family.sets.end(), step.set) != family.sets.end();
    });
    if (!part.steps.empty()) rows += family_row(family.name, part);
  }
  std::vector<Column> columns{{"Scene"}, {"Steps", true}, {"Within 1e-3 m/s", true}};
  for (const std::size_t solver : choices.solvers) {
    columns.push_back({"by " + code(summary.solvers[solver].text()), true});
  }
  return "<details><summary>Scene by scene</summary>\n" + table_head("cells", columns) + rows + kTableEnd +
         "</details>\n";
}

std::string misses(const Summary& summary, const ModelChoices& choices) {
  std::string text;
  std::size_t count = 0;
  for (const ModelChoice& step : choices.steps) {
    if (step.met || ++count > kMostMisses) continue;
    text += (text.empty() ? "" : ", ") + code(address(summary, step)) + " (" + scientific(step.error_m_per_s) + " m/s)";
  }
  if (count == 0) return " No step misses it.";
  const std::string more = count > kMostMisses ? fmt::format(", and {} more", count - kMostMisses) : "";
  return " The steps that miss it, with the least error that was reached: " + text + more + ".";
}

/// The median of a ratio to the time of the first model; NaN where nothing was timed.
double median_ratio(const ModelChoices& choices, double ModelChoice::*time) {
  std::vector<double> ratios;
  for (const ModelChoice& step : choices.steps) {
    const double ratio = step.*time / step.coarsest_s;
    if (step.met && std::isfinite(ratio)) ratios.push_back(ratio);
  }
  std::sort(ratios.begin(), ratios.end());
  return std::ssize(ratios) < least_problems() ? kNoNumber : quantile(ratios, 0.5);
}

Interval interval_of(const ModelChoices& choices) {
  return wilson(choices.met(), static_cast<std::int64_t>(choices.steps.size()));
}

}  // namespace

std::int64_t ModelChoices::met() const {
  return std::count_if(steps.begin(), steps.end(), [](const ModelChoice& step) { return step.met; });
}

std::int64_t ModelChoices::chosen(std::size_t solver) const {
  return std::count_if(steps.begin(), steps.end(),
                       [&](const ModelChoice& step) { return step.met && step.solver == solver; });
}

ModelChoices model_choices(const Summary& summary) {
  ModelChoices choices;
  std::vector<std::size_t> solvers = climbed_solvers(summary);
  const bool has_first = solvers.front() != ModelChoice::kNone;
  std::erase(solvers, ModelChoice::kNone);
  if (!has_first || solvers.size() < 2) return choices;
  std::map<StepName, std::vector<const Outcome*>> steps;
  for (const Cell& cell : summary.cells) {
    const auto at = std::find(solvers.begin(), solvers.end(), cell.solver);
    if (at == solvers.end() || !summary.sets[cell.set].frictional || !scene_name(summary.sets[cell.set].name)) continue;
    for (const Outcome& outcome : cell.outcomes) {
      std::vector<const Outcome*>& by_solver = steps[{cell.set, outcome.trial}];
      by_solver.resize(solvers.size());
      by_solver[static_cast<std::size_t>(at - solvers.begin())] = &outcome;
    }
  }
  for (const auto& [name, by_solver] : steps) {
    if (by_solver.front() == nullptr) continue;  // the models are compared where the coarsest was tried
    ModelChoice choice = choose(solvers, by_solver);
    if (choice.solver == ModelChoice::kNone) {
      ++choices.unknown;
      continue;
    }
    std::tie(choice.set, choice.trial) = name;
    choices.steps.push_back(choice);
  }
  choices.solvers = std::move(solvers);
  return choices;
}

Json model_choice_json(const Summary& summary, const std::vector<ModelChoice>& steps) {
  Json records = Json::array();
  for (const ModelChoice& step : steps) {
    records.push_back({{"set", summary.sets[step.set].name},
                       {"trial", step.trial},
                       {"solver", step.solver == ModelChoice::kNone ? "" : summary.solvers[step.solver].text()},
                       {"error_m_per_s", step.error_m_per_s},
                       {"met", step.met},
                       {"time_s", step.time_s},
                       {"spent_s", step.spent_s},
                       {"coarsest_s", step.coarsest_s}});
  }
  return records;
}

Json model_choices_json(const Summary& summary, const ModelChoices& choices) {
  Json json;
  json["error_m_per_s"] = kStatedModelError;
  json["steps"] = choices.steps.size();
  json["unknown"] = choices.unknown;
  json["met"] = choices.met();
  const Interval interval = choices.steps.empty() ? Interval{kNoNumber, kNoNumber} : interval_of(choices);
  json["share_low"] = interval.low;
  json["share_high"] = interval.high;
  json["chosen"] = Json::array();
  for (const std::size_t solver : choices.solvers) {
    json["chosen"].push_back({{"solver", summary.solvers[solver].text()}, {"steps", choices.chosen(solver)}});
  }
  json["missed"] = Json::array();
  for (const ModelChoice& step : choices.steps) {
    if (!step.met)
      json["missed"].push_back({{"problem", address(summary, step)}, {"error_m_per_s", step.error_m_per_s}});
  }
  return json;
}

std::string model_choice_part(const Summary& summary, const ModelChoices& choices) {
  if (choices.steps.empty()) return "";
  std::string names;
  for (const std::size_t solver : choices.solvers) {
    names += (names.empty() ? "" : ", then ") + code(summary.solvers[solver].text());
  }
  std::string text = fmt::format(
      "<h3 id=\"model-choice\">The model that a step needs for 10<sup>−3</sup> m/s</h3>\n<p>Each captured step with "
      "friction gets the first of these solvers whose measured error against the round Coulomb cone is at most 10<sup>"
      "−3</sup> m/s: {}. So {} of {} are within it ({}; 95 % interval {}).{}",
      names, choices.met(), counted(static_cast<std::int64_t>(choices.steps.size()), "step"),
      percent(static_cast<double>(choices.met()) / static_cast<double>(choices.steps.size())),
      percent_range(interval_of(choices)), misses(summary, choices));
  if (const double ratio = median_ratio(choices, &ModelChoice::time_s); std::isfinite(ratio)) {
    text += fmt::format(
        " The chosen solver takes {} times the time of the first one in the median, with those tried before it {} "
        "times.",
        factor(ratio), factor(median_ratio(choices, &ModelChoice::spent_s)));
  }
  if (choices.unknown > 0) {
    text += fmt::format(" Left out, because they have no friction or no answer: {}.", counted(choices.unknown, "step"));
  }
  return text + " The numbers are in <code>tables/model_choice.csv</code>.</p>\n" + families_table(summary, choices);
}

}  // namespace lcpbench::report
