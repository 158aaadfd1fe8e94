#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "study/report/axes.h"
#include "study/report/coverage_text.h"
#include "study/report/hard.h"
#include "study/report/page.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

constexpr const char* kIntroduction =
    "<section id=\"speed-error\"><h2>Every set: speed against error</h2>\n"
    "<p>One row per set; open a set below for its picture and for all solvers.</p>\n"
    "<details><summary>How to read the sets</summary>\n"
    "<p>Pictures have one point per solver and setting; the rungs of a precision ladder are settings. Errors are those "
    "of the answers said to be solved: median, and the 99th percentile, which decides. <strong>True error</strong>: "
    "the distance of the post-impact velocity from the certified one, ‖v⁺ − v*‖ / ‖v‖ in the norm of the inertia, on "
    "sets where at least half of the problems have a certified, unique v*; elsewhere the error ρ that verdicts are "
    "taken on, or the backward error of bare problems. One set has one measure.</p>\n"
    "<p><strong class=\"good\">Frontier</strong>: reliable, and no reliable solver is at least as cheap and as "
    "accurate and better in one. Frontier and cheapest solver go by the estimates, not by their intervals.</p>\n"
    "<p><strong class=\"bad\">Failed</strong>: solved less than 90 % of the problems. The error of the few that it "
    "solved is no error of the set, so pictures show it as a hollow red point in a band of its own.</p>\n"
    "<p>Small numbers in the tables are 95 % intervals. Headings sort. “Solved” is our verdict on the answer, of the "
    "problems not proven unsolvable; what the solver said of itself plays no part in it. "
    "<code>tables/results.csv</code> has these rows for a spreadsheet or for pandas, <code>tables/cells.csv</code> and "
    "<code>summary.json</code> have every number.</p>\n";


std::string count_cell(std::int64_t count, std::int64_t trials, bool bad, const std::string& note = {}) {
  const Share share{count, trials};
  const char* cls = count == 0 ? "zero" : bad ? "bad" : "";
  const std::string interval = count == 0 ? "≤ " + percent(share.interval().high) : percent_range(share.interval());
  return number_cell(share.value(), fmt::format("<span class=\"{}\">{}</span>", cls, percent(share.value())),
                     note.empty() ? interval : interval + "; " + note);
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
    case Ground::kOtherModel: return "not ranked<small>solves the round cone</small>";
    case Ground::kNoTime: return "not ranked<small>nobody measured its time</small>";
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

std::string trials_cell(const Summary& summary, const Cell& cell) {
  const std::int64_t problems = summary.sets[cell.set].problems;
  std::string detail;
  if (cell.trials < problems) detail = fmt::format("of {}", problems);
  if (cell.unsolvable_problems > 0) {
    detail += fmt::format("{}{} unsolvable", detail.empty() ? "" : "<br>", cell.unsolvable_problems);
  }
  return number_cell(static_cast<double>(cell.trials), std::to_string(cell.trials), detail);
}

/// A solver on a set, with its point where the set has one measure of error.
struct Row {
  const Cell* cell = nullptr;
  const SpeedErrorPoint* point = nullptr;
};

/// The reliable ones first, then by cost; those that take no problem of the set last.
std::vector<Row> rows_of(const Summary& summary, std::size_t set, const SpeedError* speed_error) {
  std::vector<Row> rows;
  for (const Cell& cell : summary.cells) {
    if (cell.set != set || !summary.solvers[cell.solver].sweep.empty()) continue;
    Row row{&cell, nullptr};
    if (speed_error != nullptr) {
      const auto point = std::find_if(speed_error->points.begin(), speed_error->points.end(),
                                      [&cell](const SpeedErrorPoint& each) { return each.cell == &cell; });
      if (point != speed_error->points.end()) row.point = &*point;
    }
    rows.push_back(row);
  }
  std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
    const auto key = [](const Row& row) {
      const bool placed = row.point != nullptr && row.point->placed();
      return std::tuple(row.cell->refused(), row.point == nullptr || !row.point->reliable(),
                        placed ? row.point->cost.value : HUGE_VAL);
    };
    return key(a) < key(b);
  });
  return rows;
}

const std::vector<Column> kColumns{{"Solver"},
                                   {"Standing"},
                                   {"Problems", true},
                                   {"Solved", true},
                                   {"Said solved, was wrong", true},
                                   {"Gave up", true},
                                   {"Time / reference", true},
                                   {"Median time", true},
                                   {"Error, median", true},
                                   {"Error, 99 %", true}};

std::string refused_row(const std::string& heading, const Cell& cell) {
  return fmt::format(
      "<tr>{}<td></td><td data-value=\"\">0<small>of {}</small></td><td colspan=\"{}\">does not take these problems: "
      "{}</td></tr>\n",
      heading, cell.trials, kColumns.size() - 3, escape(cell.refusal));
}

std::string factor_cell(const Summary& summary, const Cell& cell) {
  const bool is_reference = summary.solvers[cell.solver].text() == summary.reference;
  const TimeFactor ratio = over_reference(cell);
  const std::string detail =
      is_reference    ? ""
      : ratio.shown() ? fmt::format("{}–{}, n = {}", factor(ratio.ratio.low), factor(ratio.ratio.high), ratio.problems)
                      : fmt::format("{} of {}", ratio.problems, ratio.of);
  return number_cell(ratio.shown() ? ratio.ratio.value : std::nan(""),
                     is_reference    ? "1"
                     : ratio.shown() ? factor(ratio.ratio.value)
                                     : "–",
                     detail, " data-factor=\"" + factor_key(cell.set, cell.solver) + "\"");
}

std::string solver_row(const Summary& summary, const Row& row) {
  const Cell& cell = *row.cell;
  const std::string heading = "<th scope=\"row\">" + code(summary.solvers[cell.solver].text()) + "</th>";
  if (cell.refused()) return refused_row(heading, cell);
  const std::int64_t refused = cell.count(Claim::kUnsupported);
  std::string text = "<tr>" + heading + "<td>" + (row.point == nullptr ? "" : rank_text(*row.point)) + "</td>";
  text += trials_cell(summary, cell);
  text += number_cell(cell.rate(), percent(cell.rate()), percent_range(cell.rate_interval));
  text += count_cell(cell.false_claims(), cell.trials, true);
  text += count_cell(cell.gave_up(), cell.trials, false,
                     refused == 0 ? "" : "refused " + percent(Share{refused, cell.trials}.value()));
  text += factor_cell(summary, cell);
  text += number_cell(cell.median_time.value, duration(cell.median_time.value),
                      duration_range(cell.median_time.low, cell.median_time.high));
  const double median = row.point == nullptr ? cell.error_median : row.point->median;
  const double p99 = row.point == nullptr ? cell.error_p99 : row.point->p99;
  const bool all_known = row.point == nullptr || row.point->known == row.point->answers;
  text += number_cell(median, scientific(median),
                      all_known ? "" : fmt::format("of {} of {} answers", row.point->known, row.point->answers));
  return text + number_cell(p99, scientific(p99)) + "</tr>\n";
}

std::string solvers_table(const Summary& summary, std::size_t set, const SpeedError* speed_error) {
  std::string rows;
  for (const Row& row : rows_of(summary, set, speed_error)) rows += solver_row(summary, row);
  return rows.empty() ? "" : table_head("cells", kColumns) + rows + kTableEnd;
}

std::string settings_detail(const std::string& settings) { return settings.empty() ? "defaults" : code(settings); }

std::string range_cells(const SweepSummary::Range& range) {
  return number_cell(range.worst, percent(range.worst), settings_detail(range.worst_settings)) +
         number_cell(range.average, percent(range.average)) +
         number_cell(range.best, percent(range.best), settings_detail(range.best_settings));
}

std::string sweep_table(const Summary& summary, std::size_t set) {
  const std::vector<Column> columns{
      {"Solver, sweep"}, {"Cells", true}, {"Problems", true},       {"Verdict: worst", true},
      {"average", true}, {"best", true},  {"best, held out", true}, {"Criterion: worst", true},
      {"average", true}, {"best", true}};
  std::string rows;
  for (const SweepSummary& sweep : summary.sweeps) {
    if (sweep.set != set) continue;
    rows += fmt::format("<tr><th scope=\"row\">{}<small>{}</small></th>", code(sweep.solver), code(sweep.sweep));
    rows += number_cell(static_cast<double>(sweep.parameterisations), std::to_string(sweep.parameterisations));
    rows += number_cell(static_cast<double>(sweep.trials), std::to_string(sweep.trials));
    rows += range_cells(sweep.verdict);
    rows += number_cell(sweep.best_held_out, percent(sweep.best_held_out));
    rows += range_cells(sweep.criterion) + "</tr>\n";
  }
  if (rows.empty()) return "";
  return "<p class=\"note\">Sweeps: shares solved over all parameterisations of a grid, by our verdict and by the "
         "paper’s criterion. “Held out”: chosen on the even trials, reported on the odd ones.</p>\n" +
         table_head("cells", columns) + rows + kTableEnd;
}

/// "contact_lemke, 0.0089", and how well it meets the target.
std::string chosen_cell(const Summary& summary, const SpeedError& set, std::optional<std::size_t> place,
                        double SpeedErrorPoint::*error) {
  if (!place) return "<td class=\"zero\">none</td>";
  const SpeedErrorPoint& point = set.points[*place];
  const std::string time = cost_text(set, point) + (set.relative ? " of the reference’s time" : "");
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
  std::string table = table_head("", {{"Error at most"}, {"in 99 % of its answers"}, {"in the median"}},
                                 "The cheapest reliable solver that meets an error");
  for (const Cheapest& cheapest : set.cheapest) {
    table += target_heading(cheapest.target) + chosen_cell(summary, set, cheapest.by_p99, &SpeedErrorPoint::p99) +
             chosen_cell(summary, set, cheapest.by_median, &SpeedErrorPoint::median) + "</tr>\n";
  }
  return table + kTableEnd;
}

std::string size_words(const SetSummary& set) {
  const std::string n = set.smallest_n == set.largest_n ? std::to_string(set.largest_n)
                                                        : fmt::format("{}–{}", set.smallest_n, set.largest_n);
  return fmt::format("{}, n = {}", counted(set.problems, "problem"), n);
}

std::string coverage_words(const Summary& summary, const SetSummary& set) {
  const std::string coverage = set_coverage(summary.coverage, set.name);
  return coverage.empty() ? "" : " <span class=\"bad\">Only " + escape(coverage) + ".</span>";
}

std::string measure_sentence(const Summary& summary, const SpeedError& speed_error) {
  const SetSummary& info = summary.sets[speed_error.set];
  std::string words = " Measured by the " + measure_words(speed_error.measure);
  if (speed_error.measure == ErrorMeasure::kForward) {
    words += fmt::format(", of {} of {}", info.unique_velocities, counted(info.problems, "problem"));
  }
  if (speed_error.measure == ErrorMeasure::kResidual) {
    words += info.unique_velocities == 0 ? "; no problem of this set has a certified, unique velocity"
                                         : fmt::format("; only {} of {} have a certified, unique velocity",
                                                       info.unique_velocities, counted(info.problems, "problem"));
  }
  if (!speed_error.relative) words += ". The reference solved none of them: times instead of ratios";
  return words + ".";
}

/// "More pictures: ...", the files beside the page.
std::string more_pictures(std::size_t set, const Figures& figures) {
  std::string links;
  const auto add = [&links, set](const std::map<std::size_t, Figure>& kind, const char* words) {
    const auto figure = kind.find(set);
    if (figure == kind.end()) return;
    links += (links.empty() ? "" : ", ") + ("<a href=\"" + figure->second.file + "\">" + words + "</a>");
  };
  add(figures.distribution, "errors of the answers said to be solved");
  add(figures.error_ecdf, "errors of all answers");
  return links.empty() ? "" : "<p class=\"note\">More pictures: " + links + ".</p>\n";
}

const SpeedError* of_set(const SpeedErrorStudy& study, std::size_t set) {
  const auto found =
      std::find_if(study.sets.begin(), study.sets.end(), [set](const SpeedError& each) { return each.set == set; });
  return found == study.sets.end() ? nullptr : &*found;
}

std::string set_part(const Summary& summary, std::size_t set, const SpeedErrorStudy& study, const Figures& figures) {
  const SetSummary& info = summary.sets[set];
  const SpeedError* speed_error = of_set(study, set);
  std::string part = fmt::format("<details><summary><span id=\"set-{}\">{}</span></summary>\n<p class=\"note\">{}; {}.",
                                 set, code(info.name), describe(info), size_words(info));
  if (info.all_solvable) part += " All proven solvable.";
  if (speed_error != nullptr) part += measure_sentence(summary, *speed_error);
  part += coverage_words(summary, info) + "</p>\n" + figure_html(figures.speed_error, set);
  part += solvers_table(summary, set, speed_error);
  if (speed_error != nullptr) part += cheapest_table(summary, *speed_error);
  return part + sweep_table(summary, set) + more_pictures(set, figures) + "</details>\n";
}

/// The cheapest point of the frontier; nullptr where there is none.
const SpeedErrorPoint* cheapest_reliable(const SpeedError* speed_error) {
  const SpeedErrorPoint* best = nullptr;
  if (speed_error == nullptr) return best;
  for (const SpeedErrorPoint& point : speed_error->points) {
    if (point.frontier && (best == nullptr || point.cost.value < best->cost.value)) best = &point;
  }
  return best;
}

std::string overview_row(const Summary& summary, std::size_t set, const SpeedErrorStudy& study) {
  const SetSummary& info = summary.sets[set];
  const SpeedError* speed_error = of_set(study, set);
  std::string row = fmt::format("<tr><th scope=\"row\"><a href=\"#set-{}\">{}</a><small>{}; {}</small>", set,
                                code(info.name), describe(info), size_words(info));
  row += coverage_words(summary, info) + "</th>";
  if (const SpeedErrorPoint* best = cheapest_reliable(speed_error)) {
    row += "<td>" + breakable_name(summary.solvers[best->cell->solver]) + "</td>";
    row += number_cell(best->cell->median_time.value, duration(best->cell->median_time.value));
    row += number_cell(best->p99, scientific(best->p99));
  } else {
    row += speed_error != nullptr && speed_error->too_few() ? "<td>too few to say</td>" : "<td>none</td>";
    row += number_cell(std::nan(""), "–") + number_cell(std::nan(""), "–");
  }
  const auto wrong = std::count_if(summary.cells.begin(), summary.cells.end(), [&](const Cell& cell) {
    return cell.set == set && summary.solvers[cell.solver].sweep.empty() && cell.false_claims() > 0;
  });
  row += number_cell(static_cast<double>(wrong),
                     fmt::format("<span class=\"{}\">{}</span>", wrong > 0 ? "bad" : "zero", wrong));
  return row + "</tr>\n";
}

// --- conditioning ---

std::vector<Column> condition_columns(const char* first, const Conditioning& family) {
  std::vector<Column> columns{{first}};
  for (const double condition : family.conditions) columns.push_back({condition_text(condition), true});
  return columns;
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
  std::string table = table_head(
      "cells", condition_columns("Solver", family),
      "By condition number: the error’s 99th percentile; below it its median, and the time as above. Green: frontier. "
      "Grey: not reliable there, or too few problems to say.");
  for (const std::size_t solver : family.solvers) {
    table += "<tr><th scope=\"row\">" + code(summary.solvers[solver].text()) + "</th>";
    for (const SpeedError& step : family.steps) table += condition_cell(step, solver);
    table += "</tr>\n";
  }
  return table + kTableEnd;
}

std::string cheapest_by_condition(const Summary& summary, const Conditioning& family) {
  std::string table = table_head("", condition_columns("Error at most", family),
                                 "The cheapest reliable solver whose error is at most this in 99 % of its answers");
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
  return "<details><summary>" + code(family.family) + "</summary>\n<p class=\"note\">Measured by the " +
         measure_words(family.measure) + ", the same at all condition numbers.</p>\n" +
         figure_html(figures.conditioning, index) + conditioning_table(summary, family) +
         cheapest_by_condition(summary, family) + "</details>\n";
}

}  // namespace

std::string speed_error_section(const Report& report) {
  const Summary& summary = report.summary;
  const SpeedErrorStudy& study = report.speed_error;
  const Figures& figures = report.figures;
  if (has_only_hard_sets(summary)) return "";
  std::string rows;
  std::string parts;
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    if (is_hard_set(summary.sets[set].name)) continue;
    rows += overview_row(summary, set, study);
    parts += set_part(summary, set, study, figures);
  }
  std::string section = kIntroduction;
  section += "<p>" + reliability_rule_html() + "</p>\n";
  if (!summary.reference.empty()) {
    section += "<p>Reference of the times: " + code(summary.reference) +
               ", on the n problems that both solved; below 1 is faster. Fewer than " +
               std::to_string(least_problems()) + " carry no factor: how many of how many stands there.</p>\n";
  }
  section += "</details>\n";
  if (rows.empty()) return section + "<p>The store holds no problems.</p>\n</section>\n";
  section += table_head("cells overview", {{"Set"},
                                           {"Fastest reliable solver"},
                                           {"Its median time", true},
                                           {"Its error, 99 %", true},
                                           {"Solvers that said solved and were wrong", true}}) +
             rows + kTableEnd + parts;
  if (!study.families.empty()) {
    section +=
        "<h3 id=\"conditioning\">How it moves with conditioning</h3>\n<p>Sets that differ in the inertia’s condition "
        "number alone.</p>\n";
  }
  for (std::size_t i = 0; i < study.families.size(); ++i) section += family_part(summary, study, i, figures);
  return section + "</section>\n";
}

}  // namespace lcpbench::report
