#include "study/report/page.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "study/report/canvas.h"
#include "study/report/comparison_section.h"
#include "study/report/coverage_notice.h"
#include "study/report/hard.h"
#include "study/report/hard_section.h"
#include "study/report/provenance_section.h"
#include "study/report/references.h"
#include "study/report/sections.h"
#include "study/report/speed_error_section.h"
#include "study/report/style.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

/// A link to a section, where the page has it.
std::string section_link(const std::string& sections, const std::string& id, const char* title) {
  const bool present = sections.find("<section id=\"" + id + "\"") != std::string::npos;
  return present ? "<a href=\"#" + id + "\">" + title + "</a>" : "";
}

std::string navigation(const Summary& summary, const PaperStudy& paper, const std::string& sections) {
  const auto link = [&sections](const char* id, const char* title) { return section_link(sections, id, title); };
  return "<nav aria-label=\"Contents\"><a href=\"#answer\">Answer</a>" + link("speed-error", "Every set") +
         link("comparison", "Comparing solvers") + hard_navigation(summary) +
         link("claims", "Claim against verdict") + paper_navigation(paper) + link("times", "What each time contains") +
         link("provenance", "Provenance") + link("definitions", "Definitions") + link("limits", "Limits") + "</nav>\n";
}

std::string share_line(const Share& share) {
  const char* cls = share.part > 0 ? "bad" : "zero";
  return fmt::format("<span class=\"{}\">{}</span> <small>{}</small>", cls, percent(share.value()),
                     percent_range(share.interval()));
}

/// A solver's name that a narrow column breaks before its settings, not within a word.
std::string breakable_name(const SolverRow& solver) {
  std::string name = code(solver.text());
  const std::size_t brace = name.find('{');
  if (brace != std::string::npos) name.insert(brace + 1, "<wbr>");
  return name;
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
    cell += fmt::format("<small data-speed=\"{}\">{}, {}–{}×</small>", situation_key(situation, best.solver), speed,
                        factor(best.speedup.low), factor(best.speedup.high));
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
  constexpr std::size_t kShown = 4;
  std::vector<std::string> reasons;
  for (const Contender& contender : situation.contenders) {
    if (contender.verdict.empty()) continue;
    reasons.push_back((contender.false_claims.part > 0 ? "<li class=\"bad\">" : "<li>") +
                      code(summary.solvers[contender.solver].text()) + ": " + escape(contender.verdict) + "</li>");
  }
  const std::size_t shown = reasons.size() > kShown + 1 ? kShown : reasons.size();
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

/// Every solver at single settings that said solved and was wrong, on whatever set, those of whom it is surest first.
std::string false_claims_line(const Summary& summary) {
  std::map<std::size_t, Share> false_claims;
  for (const Cell& cell : summary.cells) {
    if (!summary.solvers[cell.solver].sweep.empty()) continue;
    false_claims[cell.solver].part += cell.false_claims();
    false_claims[cell.solver].whole += cell.trials - cell.count(Claim::kUnsupported);
  }
  if (false_claims.empty()) return "";
  std::erase_if(false_claims, [](const auto& entry) { return entry.second.part == 0; });
  if (false_claims.empty()) return "<p>No solver here said solved and was wrong.</p>\n";
  std::vector<std::pair<std::size_t, Share>> caught(false_claims.begin(), false_claims.end());
  std::stable_sort(caught.begin(), caught.end(),
                   [](const auto& a, const auto& b) { return a.second.interval().low > b.second.interval().low; });
  std::string names;
  for (const auto& [solver, share] : caught) {
    names += fmt::format("{}{} on {} of {}", names.empty() ? "" : "; ", code(solver_label(summary, solver)), share.part,
                         counted(share.whole, "problem"));
  }
  return "<p class=\"caught\"><span class=\"bad\">Said solved, was wrong:</span> " + names + ".</p>\n";
}

/// "" where the store has nothing that a solver could be recommended for.
std::string decision_table(const Summary& summary, const std::vector<Situation>& situations) {
  if (only_special_sets(summary, situations)) return "";
  std::string table =
      "<div class=\"scroll\" tabindex=\"0\"><table class=\"decision\"><thead><tr><th scope=\"col\">Contacts</th>"
      "<th scope=\"col\">Use</th><th scope=\"col\">Time per problem</th><th scope=\"col\">What it gets wrong</th>"
      "<th scope=\"col\">Why not the others</th></tr></thead><tbody>\n";
  for (std::size_t i = 0; i < situations.size(); ++i) table += decision_row(summary, situations[i], i);
  return table + "</tbody></table></div>\n";
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

}  // namespace

std::string figure_html(const std::map<std::size_t, Figure>& figures, std::size_t index) {
  const auto figure = figures.find(index);
  if (figure == figures.end()) return "";
  return "<figure><div class=\"scroll\" tabindex=\"0\">" + inline_svg(figure->second.svg) + "</div></figure>\n";
}

std::string html_page(const Summary& summary, const std::vector<Situation>& situations,
                      const std::vector<SetComparison>& comparisons, const SpeedErrorStudy& speed_error,
                      const Figures& figures, const PaperStudy& paper) {
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>lcpbench report</title>\n<style>";
  page += kStyle;
  page += kFigureStyle;
  page += "</style></head>\n<body>\n<header id=\"answer\">\n";
  page += "<h1>Which solver should turn contacts into impulses, and what does it cost in speed and error?</h1>\n";
  page += coverage_html(summary.coverage);
  page += "<p class=\"answer\">" + one_line_answer(summary, situations) + "</p>\n";
  page += false_claims_line(summary) + "</header>\n";
  const std::string sections = speed_error_section(summary, speed_error, figures) +
                               comparison_section(summary, comparisons, figures) + hard_section(summary) +
                               claims_section(summary) + paper_sections(summary, paper) + times_section(summary) +
                               provenance_section(summary) + "<details><summary>Definitions: what the words of this page mean</summary>\n" +
                               definitions_section() + "</details>\n" + limits_section(summary);
  page += navigation(summary, paper, sections) + "<main>\n";
  const std::string table = decision_table(summary, situations);
  if (!table.empty()) page += reference_choice(summary);
  page += table;
  page += headline_figure(summary, figures);
  page += "<h3>Three limits</h3>\n" + three_limits(summary, situations);
  page += sections;
  page += "</main>\n" + reference_data(summary, situations) + "<script>";
  page += kScript;
  return page + "</script>\n</body></html>\n";
}

}  // namespace lcpbench::report
