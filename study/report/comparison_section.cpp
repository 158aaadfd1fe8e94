#include "study/report/comparison_section.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "study/report/comparison_tables.h"
#include "study/report/html_table.h"
#include "study/report/sections.h"
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

std::string p_value(double p) { return p < 1e-99 ? "&lt; 1e-99" : fmt::format("{:.2g}", p); }

// --- pairs ---

std::string pair_verdict(const Summary& summary, const PairedCounts& pair) {
  const std::optional<std::size_t> better = pair.better();
  return better ? solver_code(summary, *better) + " solves more" : "not told apart";
}

std::string pairs_table(const Summary& summary, const SetComparison& comparison) {
  if (comparison.pairs.empty()) return "";
  constexpr Column kColumns[] = {{"First", false},       {"Second", false}, {"Problems", true}, {"Only first", true},
                                 {"Only second", true},  {"Both", true},    {"Neither", true},  {"p", true},
                                 {"p, corrected", true}, {"Verdict", false}};
  std::string rows;
  for (const PairedCounts& pair : comparison.pairs) {
    rows += "<tr>" + row_heading(summary, pair.first) + "<td>" + solver_code(summary, pair.second) + "</td>";
    for (const std::int64_t count : {pair.problems, pair.only_first, pair.only_second, pair.both, pair.neither}) {
      rows += count_cell(count);
    }
    rows += number_cell(pair.p, p_value(pair.p)) + number_cell(pair.p_holm, p_value(pair.p_holm));
    rows += "<td>" + pair_verdict(summary, pair) + "</td></tr>\n";
  }
  return "<h4>Who solves what the other does not</h4>\n" + table_head("cells", kColumns) + rows + kTableEnd;
}

// --- times ---

std::string seconds_cell(const Estimate& estimate) {
  return number_cell(estimate.value, duration(estimate.value), duration_range(estimate.low, estimate.high));
}

std::string times_table(const Summary& summary, const SetComparison& comparison) {
  constexpr Column kColumns[] = {
      {"Solver", false}, {"Problems", true}, {"Solved", true}, {"Median time", true}, {"Shifted geometric mean", true},
      {"PAR‑10", true}};
  std::string rows;
  for (const SolverTimes& times : comparison.times) {
    rows += "<tr>" + row_heading(summary, times.solver) + count_cell(times.problems);
    rows += share_cell(times.solved, times.problems);
    rows += seconds_cell(times.median) + seconds_cell(times.geometric_mean);
    rows += number_cell(times.par10, duration(times.par10)) + "</tr>\n";
  }
  return "<h4>Times, slow and failed solves weighed in three ways</h4>\n" + table_head("cells", kColumns) + rows +
         kTableEnd;
}

// --- profiles ---

std::size_t factor_index(double factor) {
  return static_cast<std::size_t>(std::find(kProfileFactors.begin(), kProfileFactors.end(), factor) -
                                  kProfileFactors.begin());
}

std::string profiles_table(const Summary& summary, const SetComparison& comparison) {
  if (comparison.profiles.empty()) return "";
  constexpr Column kColumns[] = {
      {"Solver", false},          {"Against", false},          {"Problems", true},   {"Faster", true},
      {"Within 1.1×", true},      {"Within 2×", true},         {"Within 10×", true}, {"Within 1000×", true},
      {"Other one faster", true}, {"Other within 1000×", true}};
  std::string rows;
  for (const PairProfile& profile : comparison.profiles) {
    rows += "<tr>" + row_heading(summary, profile.solver) + "<td>" + solver_code(summary, profile.against) + "</td>";
    rows += count_cell(profile.problems);
    for (const double factor : {1.0, 1.1, 2.0, 10.0, 1000.0}) {
      const double share = profile.solver_shares[factor_index(factor)];
      rows += number_cell(share, percent(share));
    }
    for (const double factor : {1.0, 1000.0}) {
      const double share = profile.against_shares[factor_index(factor)];
      rows += number_cell(share, percent(share));
    }
    rows += "</tr>\n";
  }
  return "<h4>Profiles of two</h4>\n<p class=\"note\">Share of the problems that a solver solved within a factor of "
         "the "
         "faster of the two.</p>\n" +
         table_head("cells", kColumns) + rows + kTableEnd;
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

std::string contributions_table(const Summary& summary, const VirtualBest& best) {
  constexpr Column kColumns[] = {
      {"Solver", false}, {"Solved", true}, {"Solved by it alone", true}, {"Fastest to solve", true}};
  std::string rows;
  for (const Contribution& part : best.contributions) {
    rows += "<tr>" + row_heading(summary, part.solver) + share_cell(part.solved, best.problems);
    rows += count_cell(part.alone) + count_cell(part.fastest) + "</tr>\n";
  }
  return table_head("cells", kColumns) + rows + kTableEnd;
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
      "<p>{}</p>\n<ol>{}</ol>\n<p>Mean per problem: {} solving, and {} verifying each answer in 113-bit arithmetic ({} "
      "timed). Its solved problems: <code>{}</code></p>\n",
      length, steps, duration(chain.mean_time_s), duration(chain.mean_verification_s), counted(chain.timed, "problem"),
      escape(chain_query(summary, set, chain)));
}

std::string portfolio_part(const Summary& summary, const SetComparison& comparison) {
  std::string part;
  for (const VirtualBest& best : comparison.virtual_bests) {
    part += "<h4>Virtual best solver and fallback chain</h4>\n<p class=\"note\">" + scope_words(summary, best) +
            ".</p>\n<p>" + best_words(best) + "</p>\n";
    part += contributions_table(summary, best) + chain_words(summary, comparison.set, best);
  }
  return part;
}

// --- the whole ---

std::string introduction(const Summary& summary) {
  const double limit = recorded_time_limit(summary);
  return fmt::format(
      "<p>Within a set, on the same problems. Open a set for its tables; all of them are in <code>tables/</code> "
      "(<code>mcnemar.csv</code>, <code>solver_times.csv</code>, <code>ecdf.csv</code>, <code>profiles.csv</code>, "
      "<code>vbs.csv</code>, <code>chains.csv</code>). What solvers said against what was true stands under <a "
      "href=\"#claims\">Claim against verdict</a>.</p>\n<ul>\n"
      "<li><strong>Pairs.</strong> Problems that both took. p: exact McNemar test, two-sided, on the problems that "
      "only one solved; corrected by Holm’s method for the number of pairs of the set. “Solves more” is said where the "
      "corrected p is below 5 %. Unsolvable problems count as solved by neither.</li>\n"
      "<li><strong>Times.</strong> Median and shifted geometric mean are over all problems that a solver took, "
      "failures included; 95 % intervals. The shift is {}, one period of a 1 kHz control loop: shorter solves count by "
      "their sum, longer ones by their ratio. PAR‑10 is the mean over the problems not proven unsolvable, where each "
      "unsolved one counts as ten time limits ({}).</li>\n"
      "<li><strong>Curves.</strong> Shares of the problems not proven unsolvable. A failure is in the whole and never "
      "in "
      "the share, so that a curve ends at what the solver solved.</li>\n"
      "<li><strong>Profiles</strong> compare two solvers alone: in profiles of many, leaving one out can turn the "
      "order "
      "of the others.</li>\n"
      "<li><strong>Virtual best solver.</strong> The fastest that solved each problem, known only afterwards. "
      "<strong>Fallback chain.</strong> Solvers tried one after the other until an answer passes verification. It "
      "relies on every answer being verified; what a solver claims ends nothing. All subsets of solvers are tried, so "
      "none shorter exists on these problems; its order is the cheapest here, and may not be elsewhere.</li>\n"
      "<li>Parameterisations of sweeps take no part.</li>\n</ul>\n",
      duration(kTimeShift), std::isnan(limit) ? "no run of this store recorded one" : "limit: " + duration(limit));
}

std::string set_line(const Summary& summary, const SetComparison& comparison) {
  std::string line = code(summary.sets[comparison.set].name);
  const auto told_apart = std::count_if(comparison.pairs.begin(), comparison.pairs.end(),
                                        [](const PairedCounts& pair) { return pair.better().has_value(); });
  line += fmt::format(": {} of {} told apart", told_apart, counted(std::ssize(comparison.pairs), "pair"));
  for (const VirtualBest& best : comparison.virtual_bests) {
    if (best.common_only || !best.chain) continue;
    line += "; virtual best " + percent(Share{best.solved, best.problems}.value()) + ", reached by";
    for (std::size_t i = 0; i < best.chain->steps.size(); ++i) {
      line += (i == 0 ? " " : " → ") + solver_code(summary, best.chain->steps[i].solver);
    }
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

std::string comparison_section(const Summary& summary, const std::vector<SetComparison>& comparisons,
                               const Figures& figures) {
  if (comparisons.empty()) return "";
  std::string section = "<section id=\"comparison\"><h2>Comparing solvers</h2>\n" + introduction(summary);
  for (const SetComparison& comparison : comparisons) {
    section += "<details><summary>" + set_line(summary, comparison) + "</summary>\n";
    section += pairs_table(summary, comparison) + times_table(summary, comparison);
    section += figure_html(figures.time_ecdf, comparison.set, figures.missing);
    section += figure_html(figures.error_ecdf, comparison.set, "");
    section += profiles_table(summary, comparison) + portfolio_part(summary, comparison) + "</details>\n";
  }
  return section + queries() + "</section>\n";
}

}  // namespace lcpbench::report
