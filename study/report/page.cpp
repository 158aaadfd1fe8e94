#include "study/report/page.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "study/report/comparison_section.h"
#include "study/report/hard_section.h"
#include "study/report/sections.h"
#include "study/report/speed_error_section.h"
#include "study/report/style.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

std::string navigation(const Summary& summary, const PaperStudy& paper) {
  return "<nav aria-label=\"Contents\"><a href=\"#answer\">Answer</a><a href=\"#speed-error\">Speed against error</a>"
         "<a href=\"#sets\">Every set and solver</a>"
         "<a href=\"#comparison\">Comparing solvers</a>" +
         hard_navigation(summary) + "<a href=\"#claims\">Claim against verdict</a>" + paper_navigation(paper) +
         "<a href=\"#times\">What each time contains</a>"
         "<a href=\"#provenance\">Provenance</a><a href=\"#definitions\">Definitions</a>"
         "<a href=\"#limits\">Limits</a></nav>\n";
}

std::string share_line(const Share& share) {
  const char* cls = share.part > 0 ? "bad" : "zero";
  return fmt::format("<span class=\"{}\">{}</span> <small>{}</small>", cls, percent(share.value()),
                     percent_range(share.interval()));
}

std::string use_column(const Summary& summary, const Situation& situation) {
  if (situation.contenders.empty())
    return "<td class=\"use\" data-label=\"Use\">– <small>no such problems in this study</small></td>";
  if (!situation.recommended)
    return "<td class=\"use\" data-label=\"Use\">none <small>no solver solved enough of them</small></td>";
  const Contender& best = situation.contenders[*situation.recommended];
  std::string cell = "<td class=\"use\" data-label=\"Use\">" + code(summary.solvers[best.solver].text());
  std::string ties;
  for (const Contender& contender : situation.contenders) {
    if (contender.tie) ties += (ties.empty() ? "" : ", ") + code(summary.solvers[contender.solver].text());
  }
  if (!ties.empty()) cell += "<small>a tie with " + ties + "</small>";
  cell +=
      fmt::format("<small>solved {} ({})</small>", percent(best.solved.value()), percent_range(best.solved.interval()));
  return cell + "</td>";
}

std::string time_column(const Summary& summary, const Contender& best) {
  std::string cell = fmt::format("<td data-label=\"Time per problem\">{} <small>median, {}</small>",
                                 duration(best.time.value), duration_range(best.time.low, best.time.high));
  if (summary.solvers[best.solver].text() == summary.reference) {
    cell += "<small>it is the reference of all ratios</small>";
  } else if (std::isfinite(best.speedup.value)) {
    cell += fmt::format("<small>{} the dense reference, {}–{}×</small>", speed_against(1 / best.speedup.value),
                        factor(best.speedup.low), factor(best.speedup.high));
  }
  return cell + "</td>";
}

std::string wrong_column(const Contender& best) {
  const Share unsolved{best.solved.whole - best.solved.part, best.solved.whole};
  return "<td data-label=\"What it gets wrong\"><div>said solved, was wrong: " + share_line(best.false_claims) +
         "</div><div>not solved: " + share_line(unsolved) + "</div></td>";
}

/// The table is to be seen at a glance, with the picture below it: the best few, and the others on request.
std::string reasons_column(const Summary& summary, const Situation& situation) {
  constexpr std::size_t kShown = 4;
  std::vector<std::string> reasons;
  for (const Contender& contender : situation.contenders) {
    if (contender.verdict.empty()) continue;
    reasons.push_back("<li>" + code(summary.solvers[contender.solver].text()) + ": " + contender.verdict + "</li>");
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

std::string decision_row(const Summary& summary, const Situation& situation) {
  std::string row = fmt::format("<tr><th scope=\"row\">{} <small>{}</small></th>", situation.title, situation.scope);
  row += use_column(summary, situation);
  if (situation.recommended) {
    const Contender& best = situation.contenders[*situation.recommended];
    row += time_column(summary, best) + wrong_column(best);
  } else {
    row += "<td>–</td><td>–</td>";
  }
  return row + reasons_column(summary, situation) + "</tr>\n";
}

std::string decision_table(const Summary& summary, const std::vector<Situation>& situations) {
  std::string table =
      "<div class=\"scroll\" tabindex=\"0\"><table class=\"decision\"><thead><tr><th scope=\"col\">Contacts</th>"
      "<th scope=\"col\">Use</th><th scope=\"col\">Time per problem</th><th scope=\"col\">What it gets wrong</th>"
      "<th scope=\"col\">Why not the others</th></tr></thead><tbody>\n";
  for (const Situation& situation : situations) table += decision_row(summary, situation);
  return table + "</tbody></table></div>\n";
}

std::string headline_figure(const Summary& summary, const Figures& figures) {
  const std::optional<std::size_t> set = headline_set(summary);
  if (!set) return "";
  const std::string& name = summary.sets[*set].name;
  std::string introduction;
  if (name != "paper/copositive/exp5-1e8") {
    introduction = "<p class=\"note\">This store has no " + code("paper/copositive/exp5-1e8") +
                   " (frictional contacts, inertia condition number 1e8); shown instead is the hardest set it has, " +
                   code(name) + ".</p>\n";
  }
  return introduction + figure_html(figures.speed_error, *set, figures.missing);
}

/// Upper end of the 95 % interval of "never seen" on the largest set: what the sample size can exclude at best.
std::string sample_limit(const Summary& summary) {
  std::int64_t most = 0;
  for (const Cell& cell : summary.cells) most = std::max(most, cell.trials);
  if (most == 0) return "The store holds no answers yet.";
  return fmt::format(
      "The largest sample here is {}: even there, a failure never seen may still happen in up to {} of "
      "such problems (95 % interval).",
      counted(most, "problem"), percent(wilson(0, most).high));
}

std::string three_limits(const Summary& summary) {
  return "<ol>\n<li><strong>Random problems.</strong> Most problems here are drawn at random, dense and unrelated to "
         "each "
         "other. Contacts of your robot have structure; their failure rates will differ.</li>\n"
         "<li><strong>Sample size.</strong> " +
         sample_limit(summary) +
         "</li>\n<li><strong>Cold, single solves on one machine.</strong> No warm start from the last time step, one "
         "thread, solvers at the settings shown. Ratios carry over to other machines better than times "
         "do.</li>\n</ol>\n";
}

}  // namespace

std::string figure_html(const std::map<std::size_t, Figure>& figures, std::size_t set, const std::string& missing) {
  const auto figure = figures.find(set);
  if (figure == figures.end()) {
    return missing.empty() ? "" : "<p class=\"note\">No picture: " + escape(missing) + ".</p>\n";
  }
  return fmt::format(
      "<figure><div class=\"scroll\" tabindex=\"0\"><img alt=\"{}\" "
      "src=\"data:image/svg+xml;base64,{}\"></div></figure>\n",
      escape(figure->second.alternative), base64(figure->second.svg));
}

std::string html_page(const Summary& summary, const std::vector<Situation>& situations,
                      const std::vector<SetComparison>& comparisons, const SpeedErrorStudy& speed_error,
                      const Figures& figures, const PaperStudy& paper) {
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>lcpbench report</title>\n<style>";
  page += kStyle;
  page += "</style></head>\n<body>\n<header id=\"answer\">\n";
  page += "<h1>Which solver should turn contacts into impulses, and what does it cost in speed and error?</h1>\n";
  page += "<p class=\"answer\">" + one_line_answer(summary, situations) + "</p>\n</header>\n";
  page += navigation(summary, paper) + "<main>\n";
  page += decision_table(summary, situations);
  page += headline_figure(summary, figures);
  page += "<h3>Three limits</h3>\n" + three_limits(summary);
  page += speed_error_section(summary, speed_error, figures);
  page += sets_section(summary, figures) + comparison_section(summary, comparisons, figures) + hard_section(summary) +
          claims_section(summary) + paper_sections(summary, paper) + times_section(summary) +
          provenance_section(summary) + definitions_section() + limits_section(summary);
  page += "</main>\n<script>";
  page += kScript;
  return page + "</script>\n</body></html>\n";
}

}  // namespace lcpbench::report
