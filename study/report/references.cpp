#include "study/report/references.h"

#include <cmath>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "study/report/solver_comparison.h"
#include "study/report/figures.h"
#include "study/report/hard.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

using Json = nlohmann::ordered_json;

/// Time of `a` over time of `b` on the problems that both solved; NaN where there are none.
double time_factor(const Cell& a, const Cell& b) {
  double own = 0;
  double others = 0;
  auto other = b.outcomes.begin();
  for (const Outcome& outcome : a.outcomes) {
    while (other != b.outcomes.end() && other->problem < outcome.problem) ++other;
    if (other == b.outcomes.end()) break;
    if (other->problem != outcome.problem || !outcome.solved || !other->solved) continue;
    if (std::isnan(outcome.time_s) || std::isnan(other->time_s)) continue;
    own += outcome.time_s;
    others += other->time_s;
  }
  return own / others;
}

double three_digits_or_none(double value) {
  return std::isfinite(value) && value > 0 ? std::stod(fmt::format("{:.3g}", value)) : 0;
}

Json set_factors(const std::vector<const Cell*>& cells) {
  Json of = Json::array();
  Json rows = Json::array();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    of.push_back(cells[i]->solver);
    Json row = Json::array();
    for (std::size_t j = i + 1; j < cells.size(); ++j) {
      row.push_back(three_digits_or_none(time_factor(*cells[i], *cells[j])));
    }
    rows.push_back(std::move(row));
  }
  return {{"of", std::move(of)}, {"factors", std::move(rows)}};
}

/// The recommended solver stands first.
Json situation_factors(const Situation& situation) {
  Json of = Json::array();
  Json row = Json::array();
  for (std::size_t i = 0; i < situation.contenders.size(); ++i) {
    of.push_back(situation.contenders[i].solver);
    if (i > 0) row.push_back(three_digits_or_none(situation.contenders[i].recommended_factor));
  }
  return {{"of", std::move(of)}, {"factors", Json::array({std::move(row)})}};
}

/// Solvers that a set of the page has factors of.
std::set<std::size_t> compared_solvers(const Summary& summary) {
  std::set<std::size_t> solvers;
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    if (is_hard_set(summary.sets[set].name)) continue;
    for (const Cell* cell : drawn_cells(summary, set)) solvers.insert(cell->solver);
  }
  return solvers;
}

std::string group(const Summary& summary, const std::set<std::size_t>& solvers, bool native, const char* title) {
  std::string options;
  for (const std::size_t solver : solvers) {
    if ((summary.solvers[solver].library == "native") != native) continue;
    options += fmt::format("<option value=\"{}\">{}</option>", solver, escape(solver_label(summary, solver)));
  }
  return options.empty() ? "" : fmt::format("<optgroup label=\"{}\">{}</optgroup>", title, options);
}

}  // namespace

std::string factor_key(std::size_t set, std::size_t solver) { return fmt::format("{}:{}", set, solver); }

std::string situation_key(std::size_t situation, std::size_t solver) {
  return fmt::format("s{}:{}", situation, solver);
}

std::string reference_choice(const Summary& summary) {
  const std::set<std::size_t> solvers = compared_solvers(summary);
  if (solvers.size() < 2) return "";
  const std::string standard = summary.reference.empty() ? "none" : escape(summary.reference);
  return "<p id=\"reference\" hidden><label>Show factors over <select><option value=\"\">" + standard +
         " (as printed)</option>" + group(summary, solvers, false, "Libraries") +
         group(summary, solvers, true, "Solvers of lcpbench") +
         "</select></label> <small>The table, its sentence and the tables of the sets follow; figures and intervals "
         "keep the printed reference.</small></p>\n";
}

std::string reference_data(const Summary& summary, const std::vector<Situation>& situations) {
  Json names = Json::object();
  for (const std::size_t solver : compared_solvers(summary)) {
    names[std::to_string(solver)] = mended(solver_label(summary, solver));
  }
  Json sets = Json::object();
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    if (is_hard_set(summary.sets[set].name)) continue;
    const std::vector<const Cell*> cells = drawn_cells(summary, set);
    if (cells.size() > 1) sets[std::to_string(set)] = set_factors(cells);
  }
  for (std::size_t i = 0; i < situations.size(); ++i) {
    if (situations[i].recommended) sets["s" + std::to_string(i)] = situation_factors(situations[i]);
  }
  // In a script element nothing may look like markup.
  std::string text;
  for (const char c : Json{{"solvers", std::move(names)}, {"by_set", std::move(sets)}}.dump()) {
    text += c == '<' ? std::string("\\u003c") : std::string(1, c);
  }
  return "<script type=\"application/json\" id=\"factors\">" + text + "</script>\n";
}

}  // namespace lcpbench::report
