#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "study/report/canvas.h"
#include "study/report/page.h"
#include "study/report/scenes.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

constexpr const char* kScenesIntroduction =
    "<section id=\"scenes\"><h2>Scenes</h2>\n<p>Steps that physics engines met, captured with the engines’ own "
    "contacts. "
    "A solver is judged on these contacts, not on the engine’s own rules. Grey in the pictures: what stands still. "
    "Dots: contacts, where the bodies are free.</p>\n";

/// A family of scenes with its solvers on all of its sets.
struct Family {
  const SceneFamily& scene;
  Situation situation;
  std::size_t index = 0;
};

std::string engines(const Summary& summary, const SceneFamily& family) {
  std::string words;
  for (const std::size_t set : family.sets) {
    const std::string engine = scene_name(summary.sets[set].name)->engine;
    if (!engine.empty()) words += (words.empty() ? "" : ", ") + engine;
  }
  return words;
}

std::int64_t steps(const Summary& summary, const SceneFamily& family) {
  std::int64_t count = 0;
  for (const std::size_t set : family.sets) count += summary.sets[set].problems;
  return count;
}

std::string link(const Family& family) {
  return fmt::format("<a href=\"#scene-{}\">{}</a>", family.index, code(family.scene.name));
}

std::string gallery(const std::vector<Family>& families, const Figures& figures) {
  std::string cards;
  for (const Family& family : families) {
    for (const std::size_t set : family.scene.sets) {
      const auto figure = figures.scene.find(set);
      if (figure == figures.scene.end()) continue;
      const std::string words = figure->second.alternative;
      cards += "<figure>" + inline_svg(figure->second.svg) + "<figcaption>" + link(family) + " <small>" +
               escape(words.substr(0, words.find(':'))) + "</small></figcaption></figure>\n";
      break;
    }
  }
  return cards.empty() ? "" : "<div class=\"gallery\">\n" + cards + "</div>\n";
}

/// "3 of 24", below it the largest difference.
std::string spread_cell(const Report& report, const SceneFamily& family) {
  std::int64_t steps = 0;
  std::int64_t different = 0;
  double largest = 0;
  for (const VelocitySpread& spread : report.velocity_spreads) {
    if (std::find(family.sets.begin(), family.sets.end(), spread.set) == family.sets.end()) continue;
    ++steps;
    if (!spread.differs) continue;
    ++different;
    largest = std::max(largest, spread.spread_m_per_s);
  }
  if (steps == 0) return number_cell(std::nan(""), "–");
  return number_cell(static_cast<double>(different) / static_cast<double>(steps),
                     fmt::format("{} of {}", different, steps),
                     different > 0 ? fmt::format("by up to {:.2g} m/s", largest) : "");
}

std::string overview_row(const Report& report, const Family& family) {
  const Summary& summary = report.summary;
  std::string row = fmt::format("<tr><th scope=\"row\">{}<small>{}: {}</small></th>", link(family),
                                counted(steps(summary, family.scene), "step"), escape(engines(summary, family.scene)));
  if (const auto faultless = without_fault(family.situation); !faultless.empty()) {
    const Contender& best = *faultless.front();
    row += "<td>" + breakable_name(summary.solvers[best.solver]) + "</td>" +
           number_cell(best.time.value, duration(best.time.value)) +
           number_cell(best.p99_error, scientific(best.p99_error));
  } else {
    row += "<td>none</td>" + number_cell(std::nan(""), "–") + number_cell(std::nan(""), "–");
  }
  const auto& contenders = family.situation.contenders;
  const auto wrong = std::count_if(contenders.begin(), contenders.end(),
                                   [](const Contender& each) { return each.false_claims.part > 0; });
  return row +
         number_cell(static_cast<double>(wrong),
                     fmt::format("<span class=\"{}\">{}</span>", wrong > 0 ? "bad" : "zero", wrong)) +
         spread_cell(report, family.scene) + "</tr>\n";
}

/// "8 of 8", below it the false claims and the median time.
std::string result_cell(const Share& solved, std::int64_t wrong, double time_s, double error) {
  std::string detail = wrong > 0 ? fmt::format("<span class=\"bad\">{} wrong</span>, ", wrong) : "";
  detail += duration(time_s) + (std::isnan(error) ? "" : ", ρ " + scientific(error));
  return number_cell(solved.value(), fmt::format("{} of {}", solved.part, solved.whole), detail);
}

std::string engine_cell(const Summary& summary, std::size_t set, std::size_t solver) {
  const auto cell = std::find_if(summary.cells.begin(), summary.cells.end(),
                                 [&](const Cell& each) { return each.set == set && each.solver == solver; });
  if (cell == summary.cells.end() || cell->refused()) return number_cell(std::nan(""), "–");
  return result_cell({cell->count(Verdict::kSolved), cell->solvable()}, cell->false_claims(), cell->median_time.value,
                     cell->error_p99);
}

std::string solvers_table(const Summary& summary, const Family& family) {
  std::vector<Column> columns{{"Solver"}, {"All", true}};
  for (const std::size_t set : family.scene.sets) {
    const std::string engine = scene_name(summary.sets[set].name)->engine;
    columns.push_back(
        {fmt::format("<a href=\"#set-{}\">{}</a>", set, engine.empty() ? "steps" : escape(engine)), true});
  }
  std::string rows;
  for (const Contender& contender : family.situation.contenders) {
    rows += "<tr><th scope=\"row\">" + code(summary.solvers[contender.solver].text()) + "</th>" +
            result_cell(contender.solved_of_met, contender.false_claims.part, contender.time.value,
                        contender.p99_error);
    for (const std::size_t set : family.scene.sets) rows += engine_cell(summary, set, contender.solver);
    rows += "</tr>\n";
  }
  return table_head("cells", columns,
                    "Solved, of the steps that it met and that are not proven unsolvable; a refused step is not "
                    "solved. Below: those where it said "
                    "solved and was wrong, the median time, and the error ρ of 99 % of its answers. An engine’s name "
                    "leads to the picture of speed against error.") +
         rows + kTableEnd;
}

std::string model_error_part(const Report& report) {
  if (report.model_errors.points.empty()) return "";
  return "<h3 id=\"model-error\">The model’s error and the solver’s</h3>\n" +
         model_error_words() + figure_html(report.figures.model_error, 0);
}

}  // namespace

std::string scenes_section(const Report& report) {
  const Summary& summary = report.summary;
  const std::vector<SceneFamily> scenes = scene_families(summary);
  std::vector<Family> families;
  for (const SceneFamily& scene : scenes) {
    families.push_back({scene, judge_situation(summary, scene.name, scene.sets), families.size()});
  }
  if (families.empty()) return "";
  std::string rows;
  std::string parts;
  for (const Family& family : families) {
    rows += overview_row(report, family);
    parts += fmt::format("<details><summary><span id=\"scene-{}\">{}</span></summary>\n", family.index,
                         code(family.scene.name)) +
             solvers_table(summary, family) + "</details>\n";
  }
  return kScenesIntroduction + gallery(families, report.figures) +
         table_head("cells overview", {{"Scene"},
                                       {"Fastest that solved every step"},
                                       {"Its median time", true},
                                       {"Its error ρ, 99 %", true},
                                       {"Solvers that said solved and were wrong", true},
                                       {"Steps on which verified answers move differently", true}}) +
         rows + kTableEnd + model_error_part(report) +
         model_choice_part(summary, report.model_choices) + parts + "</section>\n";
}

}  // namespace lcpbench::report
