#include "study/report/page.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "study/report/canvas.h"
#include "study/report/coverage_text.h"
#include "study/report/figures.h"
#include "study/report/hard.h"
#include "study/report/scenes.h"
#include "study/report/solver_comparison.h"
#include "study/report/style.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

std::string share_line(const Share& share) {
  const char* cls = share.part > 0 ? "bad" : "zero";
  return fmt::format("<span class=\"{}\">{}</span> <small>{}</small>", cls, percent(share.value()),
                     percent_range(share.interval()));
}

std::string use_column(const Summary& summary, const Situation& situation) {
  if (situation.contenders.empty())
    return "<td class=\"use\" data-label=\"Use\">– <small>no such problems in this study</small></td>";
  if (!situation.recommended)
    return "<td class=\"use\" data-label=\"Use\">none <small>" + situation.withheld + "</small></td>";
  const Contender& best = situation.contenders[*situation.recommended];
  std::string cell = "<td class=\"use\" data-label=\"Use\">" + breakable_name(summary.solvers[best.solver]);
  std::string ties;
  for (const Contender& contender : situation.contenders) {
    if (contender.tie) ties += (ties.empty() ? "" : ", ") + breakable_name(summary.solvers[contender.solver]);
  }
  if (!ties.empty()) cell += "<small>a tie with " + ties + "</small>";
  cell +=
      fmt::format("<small>solved {} ({})</small>", percent(best.solved.value()), percent_range(best.solved.interval()));
  return cell + "</td>";
}

std::string time_column(const Summary& summary, const Contender& best, std::size_t situation) {
  std::string cell = fmt::format("<td data-label=\"Time per problem\">{} <small>median, {}</small>",
                                 duration(best.time.value), duration_range(best.time.low, best.time.high));
  if (summary.solvers[best.solver].text() == summary.reference) {
    cell += "<small>it is the reference of all ratios</small>";
  } else if (const std::string speed = speed_beside_reference(summary, best); !speed.empty()) {
    cell += fmt::format("<small data-speed=\"{}\">{}, {}–{}×, n = {}</small>", situation_key(situation, best.solver),
                        speed, factor(best.speedup.ratio.low), factor(best.speedup.ratio.high), best.speedup.problems);
  }
  return cell + "</td>";
}

std::string wrong_column(const Contender& best) {
  const Share unsolved{best.solved.whole - best.solved.part, best.solved.whole};
  return "<td data-label=\"What it gets wrong\"><div>said solved, was wrong: " + share_line(best.false_claims) +
         "</div><div>not solved: " + share_line(unsolved) +
         fmt::format("</div><div>error ρ: {} <small>99 %</small>, {} <small>median</small></div></td>",
                     scientific(best.p99_error), scientific(best.median_error));
}

/// The table is to be seen at a glance, with the picture below it: the best few, and the others on request.
std::string reasons_column(const Summary& summary, const Situation& situation) {
  constexpr std::size_t kReasonsShown = 4;
  std::vector<std::string> reasons;
  for (const Contender& contender : situation.contenders) {
    if (contender.verdict.empty()) continue;
    reasons.push_back((contender.false_claims.part > 0 ? "<li class=\"bad\">" : "<li>") +
                      code(summary.solvers[contender.solver].text()) + ": " + escape(contender.verdict) + "</li>");
  }
  const std::size_t shown = reasons.size() > kReasonsShown + 1 ? kReasonsShown : reasons.size();
  const auto list = [&reasons](std::size_t begin, std::size_t end) {
    std::string items;
    for (std::size_t i = begin; i < end; ++i) items += reasons[i];
    return "<ul>" + items + "</ul>";
  };
  std::string cell = reasons.empty() ? std::string("–") : list(0, shown);
  if (shown < reasons.size()) {
    cell += fmt::format("<details><summary>and {} more</summary>{}</details>", reasons.size() - shown,
                        list(shown, reasons.size()));
  }
  return "<td class=\"reasons\" data-label=\"Why not the others\">" + cell + "</td>";
}

std::string decision_row(const Summary& summary, const Situation& situation, std::size_t index) {
  std::string row = "<tr><th scope=\"row\">" + situation.title;
  if (!situation.scope.empty()) row += " <small>" + situation.scope + "</small>";
  row += "</th>";
  row += use_column(summary, situation);
  if (situation.recommended) {
    const Contender& best = situation.contenders[*situation.recommended];
    row += time_column(summary, best, index) + wrong_column(best);
  } else {
    row += "<td>–</td><td>–</td>";
  }
  return row + reasons_column(summary, situation) + "</tr>\n";
}

std::string false_claims_line(const Summary& summary) {
  const std::vector<std::pair<std::size_t, Share>> caught = caught_solvers(summary);
  if (caught.empty()) {
    const bool any = std::any_of(summary.cells.begin(), summary.cells.end(),
                                 [&](const Cell& cell) { return summary.solvers[cell.solver].sweep.empty(); });
    return any ? "<p>No solver here said solved and was wrong.</p>\n" : "";
  }
  std::string names;
  for (const auto& [solver, share] : caught) {
    names += fmt::format("{}{} on {} of {}", names.empty() ? "" : "; ", code(solver_label(summary, solver)), share.part,
                         counted(share.whole, "problem"));
  }
  return "<p class=\"caught\"><span class=\"bad\">Said solved, was wrong:</span> " + names + ". " +
         soft_engine_note(summary) + "</p>\n";
}

/// "" where the store has nothing that a solver could be recommended for.
std::string decision_table(const Summary& summary, const std::vector<Situation>& situations) {
  if (only_special_sets(summary, situations)) return "";
  std::string table = table_head(
      "decision", {{"Contacts"}, {"Use"}, {"Time per problem"}, {"What it gets wrong"}, {"Why not the others"}});
  const bool scenes = std::any_of(summary.sets.begin(), summary.sets.end(),
                                  [](const SetSummary& set) { return scene_kind(set).has_value(); });
  for (std::size_t i = 0; i < situations.size(); ++i) {
    if (!scenes || !situations[i].contenders.empty()) table += decision_row(summary, situations[i], i);
  }
  return table + kTableEnd;
}

std::string headline_figure(const Summary& summary, const Figures& figures) {
  const std::optional<std::size_t> set = headline_set(summary);
  if (!set) return "";
  const std::string& name = summary.sets[*set].name;
  std::string introduction;
  if (name != "paper/copositive/exp5-1e8") {
    introduction = "<p class=\"note\">This store has no " + code("paper/copositive/exp5-1e8") +
                   " (frictional contacts, inertia condition number 1e8); shown instead is the " +
                   (summary.sets.size() > 1 ? "hardest" : "only") + " set it has, " + code(name) + ".</p>\n";
  }
  return introduction + figure_html(figures.speed_error, *set);
}

std::string chosen_problems(const Summary& summary) {
  if (has_only_hard_sets(summary)) {
    return "<strong>Problems made to break solvers.</strong> The contacts of your robot need not be like any of them.";
  }
  const bool only_scenes = std::all_of(summary.sets.begin(), summary.sets.end(),
                                       [](const SetSummary& set) { return scene_kind(set).has_value(); });
  if (only_scenes && !summary.sets.empty()) {
    return "<strong>Captured problems.</strong> These are steps of a few scenes. Your own scenes differ: "
           "<code>lcpbench capture</code> and <code>capture.h</code> make a set of them.";
  }
  return "<strong>Random problems.</strong> Most problems here are drawn at random, dense and unrelated to each other. "
         "Contacts of your robot have structure; their failure rates will differ.";
}

/// Upper end of the 95 % interval of "never seen" on the largest set: what the sample size can exclude at best.
std::string sample_limit(const Summary& summary, const std::vector<Situation>& situations) {
  if (summary.cells.empty()) return "The store holds no answers yet.";
  if (has_only_hard_sets(summary)) return "One problem each: they show where a solver breaks, not how often.";
  std::int64_t most = 0;
  for (const Cell& cell : summary.cells) most = std::max(most, cell.trials);
  const bool pooled = std::any_of(situations.begin(), situations.end(),
                                  [](const Situation& situation) { return situation.sets.size() > 1; });
  return fmt::format(
      "The largest set here has {}: even there, a failure never seen may still happen in up to {} of "
      "such problems (95 % interval).{}",
      counted(most, "problem"), percent(wilson(0, most).high),
      pooled ? " The table pools sets; its intervals are those of the pool." : "");
}

std::string three_limits(const Summary& summary, const std::vector<Situation>& situations) {
  return "<ol>\n<li>" + chosen_problems(summary) + "</li>\n<li><strong>Sample size.</strong> " +
         sample_limit(summary, situations) +
         "</li>\n<li><strong>Cold, single solves on one machine.</strong> No warm start from the last time step, one "
         "thread, solvers at the settings shown. Ratios carry over to other machines better than times "
         "do.</li>\n</ol>\n";
}

using Json = nlohmann::ordered_json;

/// Time of `a` over time of `b` on the problems that both solved; 0 where they are too few for a factor.
double time_factor(const Cell& a, const Cell& b) {
  double own = 0;
  double others = 0;
  std::int64_t problems = 0;
  lcpbench::for_each_pair(a.outcomes, b.outcomes, &Outcome::problem, [&](const Outcome& left, const Outcome& right) {
    if (!left.solved || !right.solved || std::isnan(left.time_s) || std::isnan(right.time_s)) return;
    own += left.time_s;
    others += right.time_s;
    ++problems;
  });
  return problems >= least_problems() ? own / others : 0;
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
    const TimeFactor& factor = situation.contenders[i].recommended_factor;
    if (i > 0) row.push_back(factor.shown() ? three_digits_or_none(factor.ratio.value) : 0);
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

/// The choice of the reference solver, hidden until the page's script shows it; "" without two solvers to choose from.
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

/// The factors between all pairs of solvers as JSON in a script element: summed times on the problems that both solved,
/// to three digits, 0 where these are too few for a factor. Per set the solvers `of`, and for each the factors over the
/// later ones.
/// O(sets x solvers^2 x problems)
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

// --- the whole ---

/// A part of the page with its links in the navigation, which are left out where the page has no such anchor.
struct Section {
  struct Link {
    const char* anchor;
    const char* title;
  };
  std::vector<Link> links;
  std::string (*html)(const Report&);
};

const std::vector<Section> kSections{{{{"scenes", "Scenes"}}, scenes_section},
                                     {{{"replay", "Replays"}},
                                      [](const Report& report) { return replay_section(report.replays); }},
                                     {{{"speed-error", "Every set"}}, speed_error_section},
                                     {{{"comparison", "Comparing solvers"}}, comparison_section},
                                     {{{"regret", "Regret of auto"}}, regret_section},
                                     {{{"hard", "Hard cases"}}, hard_section},
                                     {{{"claims", "Claim against verdict"}}, claims_section},
                                     {{{"paper-tables", "The paper’s tables"},
                                       {"paper-claims", "The paper’s claims"},
                                       {"tolerance-maps", "Tolerance maps"}},
                                      [](const Report& report) { return paper_sections(report.summary, report.paper); }},
                                     {{{"times", "What each time contains"}}, times_section},
                                     {{{"provenance", "Provenance"}}, provenance_section},
                                     {{{"definitions", "Definitions"}}, definitions_section},
                                     {{{"limits", "Limits"}}, limits_section}};

}  // namespace

std::string factor_key(std::size_t set, std::size_t solver) { return fmt::format("{}:{}", set, solver); }

std::string figure_html(const std::map<std::size_t, Figure>& figures, std::size_t index) {
  const auto figure = figures.find(index);
  if (figure == figures.end()) return "";
  return "<figure><div class=\"scroll\" tabindex=\"0\">" + inline_svg(figure->second.svg) + "</div></figure>\n";
}

std::string html_page(const Report& report) {
  const Summary& summary = report.summary;
  std::string sections;
  std::string navigation = "<nav aria-label=\"Contents\"><a href=\"#answer\">Answer</a>";
  for (const Section& section : kSections) {
    const std::string html = section.html(report);
    for (const auto& [anchor, title] : section.links) {
      const bool present = html.find(fmt::format(" id=\"{}\">", anchor)) != std::string::npos;
      if (present) navigation += fmt::format("<a href=\"#{}\">{}</a>", anchor, title);
    }
    sections += html;
  }
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>lcpbench report</title>\n<style>";
  page += kStyle;
  page += kFigureStyle;
  page += "</style></head>\n<body>\n<header id=\"answer\">\n";
  page += "<h1>Which solver should turn contacts into impulses, and what does it cost in speed and error?</h1>\n";
  page += coverage_html(summary.coverage);
  page += "<p class=\"answer\">" + one_line_answer(summary, report.situations) + "</p>\n";
  page += false_claims_line(summary);
  if (const std::string text = truth_text(summary); !text.empty()) page += "<p>" + escape(text) + "</p>\n";
  page += "</header>\n" + navigation + "</nav>\n<main>\n";
  const std::string table = decision_table(summary, report.situations);
  if (!table.empty()) page += reference_choice(summary);
  page += table + headline_figure(summary, report.figures);
  page += "<h3>Three limits</h3>\n" + three_limits(summary, report.situations) + sections;
  page += "</main>\n" + reference_data(summary, report.situations) + "<script>";
  page += kScript;
  return page + "</script>\n</body></html>\n";
}

}  // namespace lcpbench::report
