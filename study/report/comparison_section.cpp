#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "study/report/page.h"
#include "study/report/tables.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

std::string solver_code(const Summary& summary, std::size_t solver) { return code(solver_label(summary, solver)); }

std::string row_heading(const Summary& summary, std::size_t solver) {
  return "<th scope=\"row\">" + solver_code(summary, solver) + "</th>";
}

std::string count_cell(std::int64_t count) {
  return number_cell(static_cast<double>(count), count == 0 ? "<span class=\"zero\">0</span>" : std::to_string(count));
}

std::string share_cell(std::int64_t part, std::int64_t whole) {
  const Share share{part, whole};
  return number_cell(share.value(), percent(share.value()), percent_range(share.interval()));
}

// --- solvers ---

/// How many others a solver is told apart from, by the corrected tests.
struct Tests {
  int solves_more = 0;
  int solves_fewer = 0;
  int not_told_apart = 0;
};

Tests tests_of(const SetComparison& comparison, std::size_t solver) {
  Tests tests;
  for (const ComparedPair& pair : comparison.pairs) {
    if (pair.first != solver && pair.second != solver) continue;
    const std::optional<std::size_t> better = pair.better();
    ++(!better ? tests.not_told_apart : *better == solver ? tests.solves_more : tests.solves_fewer);
  }
  return tests;
}

/// What a solver adds to the virtual best solver over all problems of the set; nullptr where it met only a part.
const Contribution* contribution_of(const SetComparison& comparison, std::size_t solver) {
  for (const VirtualBest& best : comparison.virtual_bests) {
    if (best.common_only) continue;
    for (const Contribution& part : best.contributions) {
      if (part.solver == solver) return &part;
    }
  }
  return nullptr;
}

std::string seconds_cell(const Estimate& estimate) {
  return number_cell(estimate.value, duration(estimate.value), duration_range(estimate.low, estimate.high));
}

std::string solvers_table(const Summary& summary, const SetComparison& comparison) {
  const std::vector<Column> columns{{"Solver"},
                                    {"Solved", true},
                                    {"Solves more than", true},
                                    {"Solves fewer than", true},
                                    {"Not told apart from", true},
                                    {"Solved by it alone", true},
                                    {"Fastest to solve", true},
                                    {"Shifted geometric mean", true},
                                    {"PAR‑10", true}};
  std::string rows;
  for (const SolverTimes& times : comparison.times) {
    const Tests tests = tests_of(comparison, times.solver);
    rows += "<tr>" + row_heading(summary, times.solver) + share_cell(times.solved, times.problems);
    rows += count_cell(tests.solves_more) + count_cell(tests.solves_fewer) + count_cell(tests.not_told_apart);
    if (const Contribution* part = contribution_of(comparison, times.solver)) {
      rows += count_cell(part->alone) + count_cell(part->fastest);
    } else {
      rows += number_cell(std::nan(""), "–") + number_cell(std::nan(""), "–");
    }
    rows += seconds_cell(times.geometric_mean) + number_cell(times.par10, duration(times.par10)) + "</tr>\n";
  }
  return table_head("cells", columns) + rows + kTableEnd;
}

// --- portfolio ---

std::string scope_words(const Summary& summary, const VirtualBest& best) {
  if (best.common_only) return counted(best.problems, "problem") + " that all solvers met";
  std::string words = counted(best.problems, "problem") + ", all of the set that are not proven unsolvable";
  std::string names;
  for (const std::size_t solver : best.left_out) names += (names.empty() ? "" : ", ") + solver_code(summary, solver);
  return names.empty() ? words : words + "; without " + names + ", which met only a part of them";
}

std::string best_words(const VirtualBest& best) {
  const Share solved{best.solved, best.problems};
  if (best.solved == 0) return "No solver solved any.";
  return fmt::format("The virtual best solver solves {} of {} ({}, {}) in a median of {}, a mean of {}.", best.solved,
                     best.problems, percent(solved.value()), percent_range(solved.interval()),
                     duration(best.median_time.value), duration(best.mean_time_s));
}

std::string chain_words(const Summary& summary, std::size_t set, const VirtualBest& best) {
  if (best.solved == 0) return "";
  if (!best.chain) return "<p>No chain: too many solvers to try all subsets of.</p>\n";
  const FallbackChain& chain = *best.chain;
  std::string steps;
  for (const ChainStep& step : chain.steps) {
    steps += fmt::format("<li>{}: solves {} of the {} that reach it</li>", solver_code(summary, step.solver),
                         step.solved, step.reached);
  }
  const std::string length = chain.steps.size() == 1
                                 ? "One solver solves as much as the virtual best:"
                                 : fmt::format(
                                       "The shortest chain that solves as much has {} solvers (no set of {} "
                                       "does), in the order of least mean time:",
                                       chain.steps.size(), chain.steps.size() - 1);
  return fmt::format(
      "<p>{}</p>\n<ol>{}</ol>\n<p>Mean per problem: {} solving, and {} verifying each answer from the data, with "
      "rounding bounded; in 113 bits where that leaves a doubt ({} timed). Its solved problems: <code>{}</code></p>\n",
      length, steps, duration(chain.mean_time_s), duration(chain.mean_verification_s), counted(chain.timed, "problem"),
      escape(chain_query(summary, set, chain)));
}

std::string portfolio_part(const Summary& summary, const SetComparison& comparison) {
  std::string part;
  for (const VirtualBest& best : comparison.virtual_bests) {
    part += "<h4>Virtual best solver and fallback chain</h4>\n<p class=\"note\">" + scope_words(summary, best) +
            ".</p>\n<p>" + best_words(best) + "</p>\n";
    part += chain_words(summary, comparison.set, best);
  }
  return part;
}

// --- the whole ---

std::string introduction(const Summary& summary) {
  const double limit = recorded_time_limit(summary);
  return fmt::format(
      "<p>Within a set, on the same problems. Open a set for its table. Every pair, profile and curve is in "
      "<code>tables/</code>: <code>mcnemar.csv</code>, <code>solver_times.csv</code>, <code>ecdf.csv</code>, "
      "<code>profiles.csv</code>, <code>vbs.csv</code>, <code>chains.csv</code>.</p>\n"
      "<details><summary>How to read the comparisons</summary>\n<ul>\n"
      "<li><strong>Solves more than, solves fewer than.</strong> The number of other solvers. Two solvers are compared "
      "on the problems that both took, by the exact McNemar test, two-sided, on the problems that only one solved, "
      "corrected by Holm’s method for the number of pairs of the set. They are told apart where the corrected p is "
      "below 5 %. Unsolvable problems count as solved by neither.</li>\n"
      "<li><strong>Times.</strong> The shifted geometric mean is over all problems that a solver took, failures "
      "included, with its 95 % interval. The shift is {}, one period of a 1 kHz control loop: shorter solves count by "
      "their sum, longer ones by their ratio. PAR‑10 is the mean over the problems not proven unsolvable, where each "
      "unsolved one counts as ten time limits ({}).</li>\n"
      "<li><strong>Curves.</strong> Shares of the problems not proven unsolvable. A failure is in the whole and never "
      "in the share, so that a curve ends at what the solver solved.</li>\n"
      "<li><strong>Profiles</strong> compare two solvers alone: in profiles of many, leaving one out can turn the "
      "order of the others.</li>\n"
      "<li><strong>Virtual best solver.</strong> The fastest that solved each problem, known only afterwards. "
      "“Solved by it alone” and “fastest to solve” count its problems; solvers that met only a part of the set have no "
      "such count. <strong>Fallback chain.</strong> Solvers tried one after the other until an answer passes "
      "verification. It relies on every answer being verified; what a solver claims ends nothing. All subsets of "
      "solvers are tried, so none shorter exists on these problems; its order is the cheapest here, and may not be "
      "elsewhere.</li>\n"
      "<li>Parameterisations of sweeps take no part.</li>\n</ul>\n",
      duration(kTimeShift), std::isnan(limit) ? "no run of this store recorded one" : "limit: " + duration(limit));
}

std::string set_line(const Summary& summary, const SetComparison& comparison) {
  std::string line = code(summary.sets[comparison.set].name);
  const auto told_apart = std::count_if(comparison.pairs.begin(), comparison.pairs.end(),
                                        [](const ComparedPair& pair) { return pair.better().has_value(); });
  line += fmt::format(": {} of {} told apart", told_apart, counted(std::ssize(comparison.pairs), "pair"));
  for (const VirtualBest& best : comparison.virtual_bests) {
    if (best.common_only) continue;
    line += "; virtual best " + percent(Share{best.solved, best.problems}.value());
  }
  return line;
}

std::string queries() {
  std::string text =
      "<details><summary>Queries on the store that repeat these counts</summary>\n<p>For any SQLite shell: "
      "<code>sqlite3 STORE</code>. Times and errors are compared with the targets that stand in the query.</p>\n";
  for (const CountQuery& query : kCountQueries) {
    text += "<p>" + escape(query.tables) + ":</p>\n<div class=\"scroll\" tabindex=\"0\"><pre>" + escape(query.sql) +
            "</pre></div>\n";
  }
  return text + "</details>\n";
}

}  // namespace

std::string comparison_section(const Report& report) {
  const auto& [summary, situations, comparisons, speed_error, spreads, regret, figures, paper] = report;
  if (comparisons.empty()) return "";
  std::string section =
      "<section id=\"comparison\"><h2>Comparing solvers</h2>\n" + introduction(summary) + queries() + "</details>\n";
  for (const SetComparison& comparison : comparisons) {
    section += "<details><summary>" + set_line(summary, comparison) + "</summary>\n";
    section += solvers_table(summary, comparison);
    if (const auto figure = figures.time_ecdf.find(comparison.set); figure != figures.time_ecdf.end()) {
      section += "<p class=\"note\"><a href=\"" + figure->second.file +
                 "\">Picture: share of the problems solved within a time</a>.</p>\n";
    }
    section += portfolio_part(summary, comparison) + "</details>\n";
  }
  return section + "</section>\n";
}

}  // namespace lcpbench::report
