#include "study/report/speed_error_section.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "study/report/axes.h"
#include "study/report/html_table.h"
#include "study/report/sections.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

constexpr const char* kIntroduction =
    "<section id=\"speed-error\"><h2>Speed against error</h2>\n"
    "<p>One point per solver and setting; the rungs of a precision ladder are settings. Errors are those of the "
    "answers "
    "said to be solved: median, and the 99th percentile, which decides. <strong>True error</strong>: the distance of "
    "the post-impact velocity from the certified one, ‖v⁺ − v*‖ / ‖v‖ in the norm of the inertia, on sets where at "
    "least "
    "half of the problems have a certified, unique v*; elsewhere the error ρ that verdicts are taken on, or the "
    "backward error of bare problems. One set has one measure.</p>\n"
    "<p><strong class=\"good\">Frontier</strong>: reliable, and no reliable solver is at least as cheap and as "
    "accurate "
    "and better in one. Frontier and cheapest solver go by the estimates, not by their intervals. "
    "<code>tables/speed_error.csv</code>, <code>cheapest.csv</code>, <code>conditioning.csv</code>.</p>\n";

std::string cost_text(const SpeedError& set, const SpeedErrorPoint& point) {
  if (!set.relative) return duration(point.cost.value);
  return factor(point.cost.value);
}

std::string cost_range(const Estimate& ratio) {
  const bool known = std::isfinite(ratio.low) && ratio.low < ratio.high;
  return known ? factor(ratio.low) + "–" + factor(ratio.high) : "";
}

std::string share_cell(std::int64_t count, std::int64_t trials, bool bad) {
  const double share = trials > 0 ? static_cast<double>(count) / static_cast<double>(trials) : std::nan("");
  return number_cell(share, fmt::format("<span class=\"{}\">{}</span>",
                                        count == 0 ? "zero"
                                        : bad      ? "bad"
                                                   : "",
                                        percent(share)));
}

const char* ground_words(Ground ground) {
  switch (ground) {
    case Ground::kFalseClaims: return "not reliable<small>false claims</small>";
    case Ground::kUnsolved: return "not reliable<small>solves too few</small>";
    case Ground::kBehindTheBest: return "not reliable<small>solves fewer than the best</small>";
    case Ground::kFewProblems: return "too few to say<small>too few problems</small>";
    case Ground::kSmallSample: return "too few to say<small>others met more</small>";
    case Ground::kShortOfPlan: return "too few to say<small>short of the plan</small>";
    case Ground::kWideInterval: return "too few to say<small>wide interval</small>";
    case Ground::kSomeSets:
    case Ground::kRefuses: return "not ranked<small>refuses some</small>";
    case Ground::kNone: break;
  }
  return "reliable";
}

std::string rank_text(const SpeedErrorPoint& point) {
  if (!point.reliable())
    return "<span class=\"zero\">" + std::string(ground_words(point.reliability.ground)) + "</span>";
  const std::int64_t caught = point.cell->false_claims();
  return (point.frontier ? "<span class=\"good\">frontier</span>" : "reliable") +
         (caught > 0 ? "<small class=\"bad\">but for " + counted(caught, "false claim") + "</small>" : std::string());
}

std::string known_text(const SpeedErrorPoint& point) {
  return point.known == point.answers ? std::to_string(point.known)
                                      : fmt::format("{} of {}", point.known, point.answers);
}

std::string point_row(const Summary& summary, const SpeedError& set, const SpeedErrorPoint& point) {
  const Cell& cell = *point.cell;
  std::string row = "<tr><th scope=\"row\">" + code(summary.solvers[cell.solver].text()) + "</th>";
  row += "<td>" + rank_text(point) + "</td>";
  if (set.relative) row += number_cell(point.cost.value, factor(point.cost.value), cost_range(point.cost));
  row += number_cell(cell.median_time.value, duration(cell.median_time.value));
  row += number_cell(point.median, scientific(point.median)) + number_cell(point.p99, scientific(point.p99));
  row += number_cell(static_cast<double>(point.known), known_text(point));
  row += share_cell(cell.solvable() - cell.count(Verdict::kSolved), cell.solvable(), false);
  return row + share_cell(cell.false_claims(), cell.trials, true) + "</tr>\n";
}

std::string point_table(const Summary& summary, const SpeedError& set) {
  std::vector<Column> columns{{"Solver", false}, {"Rank", false}};
  if (set.relative) columns.push_back({"Time / reference", true});
  for (const char* heading :
       {"Median time", "Error, median", "Error, 99 %", "Answers", "Not solved", "Said solved, was wrong"}) {
    columns.push_back({heading, true});
  }
  std::vector<const SpeedErrorPoint*> points;
  for (const SpeedErrorPoint& point : set.points) points.push_back(&point);
  std::stable_sort(points.begin(), points.end(), [](const SpeedErrorPoint* a, const SpeedErrorPoint* b) {
    const auto key = [](const SpeedErrorPoint* point) {
      return std::pair(!point->reliable(), point->placed() ? point->cost.value : HUGE_VAL);
    };
    return key(a) < key(b);
  });
  std::string table = table_head("cells", columns);
  for (const SpeedErrorPoint* point : points) table += point_row(summary, set, *point);
  return table + kTableEnd;
}

/// "contact_lemke, 0.0089", and how well it meets the target.
std::string chosen_cell(const Summary& summary, const SpeedError& set, std::optional<std::size_t> place,
                        double SpeedErrorPoint::*error) {
  if (!place) return "<td class=\"zero\">none</td>";
  const SpeedErrorPoint& point = set.points[*place];
  const std::string time =
      set.relative ? factor(point.cost.value) + " of the reference’s time" : duration(point.cost.value);
  return "<td>" + code(summary.solvers[point.cell->solver].text()) + "<small>" + time + "; error " +
         scientific(point.*error) + "</small></td>";
}

/// Targets are powers of ten.
std::string target_heading(double target) {
  return "<tr><th scope=\"row\" class=\"line\">" + power_of_ten(static_cast<int>(std::lround(std::log10(target)))) +
         "</th>";
}

std::string too_few_line(const SpeedError& set) {
  return "<p class=\"note\">Who is reliable here, and the frontier: " +
         too_few_text(set.most_problems, set.plan_share) + ".</p>\n";
}

std::string cheapest_table(const Summary& summary, const SpeedError& set) {
  if (set.too_few()) return too_few_line(set);
  std::string table =
      "<div class=\"scroll\" tabindex=\"0\"><table><caption>The cheapest reliable solver that meets an "
      "error</caption><thead><tr><th scope=\"col\">Error at most</th><th scope=\"col\">in 99 % of its answers</th>"
      "<th scope=\"col\">in the median</th></tr></thead><tbody>\n";
  for (const Cheapest& cheapest : set.cheapest) {
    table += target_heading(cheapest.target) + chosen_cell(summary, set, cheapest.by_p99, &SpeedErrorPoint::p99) +
             chosen_cell(summary, set, cheapest.by_median, &SpeedErrorPoint::median) + "</tr>\n";
  }
  return table + kTableEnd;
}

std::string measure_line(const Summary& summary, const SpeedError& set) {
  const SetSummary& info = summary.sets[set.set];
  std::string line = describe(info) + ". Measured by the " + measure_words(set.measure);
  if (set.measure == ErrorMeasure::kForward) {
    line += fmt::format(", of {} of {}", info.unique_velocities, counted(info.problems, "problem"));
  }
  if (set.measure == ErrorMeasure::kResidual) {
    line += info.unique_velocities == 0 ? "; no problem of this set has a certified, unique velocity"
                                        : fmt::format("; only {} of {} have a certified, unique velocity",
                                                      info.unique_velocities, counted(info.problems, "problem"));
  }
  if (!set.relative) line += ". The reference solved none of them: times instead of ratios";
  return "<p class=\"note\">" + line + ".</p>\n";
}

std::string set_part(const Summary& summary, const SpeedError& set, const Figures& figures) {
  return "<h3>" + code(summary.sets[set.set].name) + "</h3>\n" + measure_line(summary, set) +
         figure_html(figures.speed_error, set.set, figures.missing) + point_table(summary, set) +
         cheapest_table(summary, set);
}

// --- conditioning ---

std::string condition_headings(const Conditioning& family) {
  std::string headings;
  for (const double condition : family.conditions) {
    headings += "<th scope=\"col\" class=\"number\">" + condition_text(condition) + "</th>";
  }
  return headings + "</tr></thead><tbody>\n";
}

std::string condition_cell(const SpeedError& step, std::size_t solver) {
  const auto point = std::find_if(step.points.begin(), step.points.end(),
                                  [solver](const SpeedErrorPoint& each) { return each.cell->solver == solver; });
  if (point == step.points.end() || !point->placed()) return number_cell(std::nan(""), "–");
  const std::string p99 = scientific(point->p99);
  const std::string text = point->frontier     ? "<span class=\"good\">" + p99 + "</span>"
                           : point->reliable() ? p99
                                               : "<span class=\"zero\">" + p99 + "</span>";
  return number_cell(point->p99, text, scientific(point->median) + "; " + cost_text(step, *point));
}

std::string conditioning_table(const Summary& summary, const Conditioning& family) {
  std::string table =
      "<div class=\"scroll\" tabindex=\"0\"><table class=\"cells\"><caption>By condition number: the error’s 99th "
      "percentile; below it its median, and the time as above. Green: frontier. Grey: not reliable "
      "there, or too few problems to say.</caption><thead><tr><th scope=\"col\">Solver</th>" +
      condition_headings(family);
  for (const std::size_t solver : family.solvers) {
    table += "<tr><th scope=\"row\">" + code(summary.solvers[solver].text()) + "</th>";
    for (const SpeedError& step : family.steps) table += condition_cell(step, solver);
    table += "</tr>\n";
  }
  return table + kTableEnd;
}

std::string cheapest_by_condition(const Summary& summary, const Conditioning& family) {
  std::string table =
      "<div class=\"scroll\" tabindex=\"0\"><table><caption>The cheapest reliable solver whose error is at most this "
      "in "
      "99 % of its answers</caption><thead><tr><th scope=\"col\">Error at most</th>" +
      condition_headings(family);
  for (std::size_t i = 0; i < kErrorTargets.size(); ++i) {
    table += target_heading(kErrorTargets[i]);
    for (const SpeedError& step : family.steps) {
      const std::optional<std::size_t> place = step.cheapest[i].by_p99;
      if (!place) {
        table +=
            step.too_few() ? "<td class=\"number zero\">too few to say</td>" : "<td class=\"number zero\">none</td>";
        continue;
      }
      const SpeedErrorPoint& point = step.points[*place];
      table += "<td class=\"number\">" + code(rung_label(summary, point.cell->solver)) + "<small>" +
               cost_text(step, point) + "</small></td>";
    }
    table += "</tr>\n";
  }
  return table + kTableEnd;
}

std::string family_part(const Summary& summary, const SpeedErrorStudy& study, std::size_t index,
                        const Figures& figures) {
  const Conditioning& family = study.families[index];
  return "<h3>" + code(family.family) + "</h3>\n<p class=\"note\">Measured by the " + measure_words(family.measure) +
         ", the same at all condition numbers.</p>\n" + figure_html(figures.conditioning, index, figures.missing) +
         conditioning_table(summary, family) + cheapest_by_condition(summary, family);
}

}  // namespace

std::string speed_error_section(const Summary& summary, const SpeedErrorStudy& study, const Figures& figures) {
  if (study.sets.empty()) return "";
  std::string section = kIntroduction;
  section += "<p>" + reliability_rule_html() + "</p>\n";
  if (!summary.reference.empty()) {
    section += "<p>Reference of the times: " + code(summary.reference) + "; below 1 is faster.</p>\n";
  }
  for (const SpeedError& set : study.sets) {
    if (!study.is_step(summary, set.set)) section += set_part(summary, set, figures);
  }
  if (!study.families.empty()) {
    section +=
        "<h3 id=\"conditioning\">How it moves with conditioning</h3>\n<p>Sets that differ in the inertia’s condition "
        "number alone.</p>\n";
  }
  for (std::size_t i = 0; i < study.families.size(); ++i) section += family_part(summary, study, i, figures);
  return section + "</section>\n";
}

}  // namespace lcpbench::report
