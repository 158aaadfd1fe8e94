#include "study/report/sections.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include "study/report/coverage_notice.h"
#include "study/report/hard.h"
#include "study/report/html_table.h"
#include "study/report/reliability.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

std::string count_cell(std::int64_t count, std::int64_t trials, bool bad) {
  const Share share{count, trials};
  const char* cls = count == 0 ? "zero" : bad ? "bad" : "";
  return number_cell(share.value(), fmt::format("<span class=\"{}\">{}</span>", cls, percent(share.value())),
                     count == 0 ? "≤ " + percent(share.interval().high) : percent_range(share.interval()));
}

constexpr Column kCellColumns[] = {{"Solver", false},
                                   {"Problems", true},
                                   {"Solved", true},
                                   {"Said solved, was wrong", true},
                                   {"Gave up", true},
                                   {"Refused", true},
                                   {"Median time", true},
                                   {"Time / reference", true},
                                   {"Error, median", true},
                                   {"Error, 99 %", true},
                                   {"Error ≤ 1e‑6", true},
                                   {"Error ≤ 1e‑9", true},
                                   {"Paper’s criterion", true},
                                   {"Violation, max [m/s]", true}};

std::string solver_heading(const SolverRow& solver) {
  std::string detail = escape(solver.library);
  if (solver.library != "native" && !solver.version.empty()) detail += " " + escape(solver.version);
  return "<th scope=\"row\">" + code(solver.text()) + "<small>" + detail + "</small></th>";
}

std::string refused_row(const SolverRow& solver, const Cell& cell) {
  return fmt::format(
      "<tr>{}<td class=\"number\" data-value=\"\">0<small>of {}</small></td>"
      "<td colspan=\"{}\">does not take these problems: {}</td></tr>\n",
      solver_heading(solver), cell.trials, std::size(kCellColumns) - 2, escape(cell.refusal));
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

std::string cell_row(const Summary& summary, const Cell& cell) {
  const SolverRow& solver = summary.solvers[cell.solver];
  if (cell.refused()) return refused_row(solver, cell);
  const auto of_solvable = [&cell](std::int64_t count) { return Share{count, cell.solvable()}.value(); };
  const bool is_reference = solver.text() == summary.reference;
  std::string row = "<tr>" + solver_heading(solver) + trials_cell(summary, cell);
  row += number_cell(cell.rate(), percent(cell.rate()), percent_range(cell.rate_interval));
  row += count_cell(cell.false_claims(), cell.trials, true);
  row += count_cell(cell.gave_up(), cell.trials, false);
  row += count_cell(cell.count(Claim::kUnsupported), cell.trials, false);
  row += number_cell(cell.median_time.value, duration(cell.median_time.value),
                     duration_range(cell.median_time.low, cell.median_time.high));
  row += number_cell(cell.time_ratio.value, is_reference ? "1" : factor(cell.time_ratio.value),
                     is_reference || !std::isfinite(cell.time_ratio.low)
                         ? ""
                         : factor(cell.time_ratio.low) + "–" + factor(cell.time_ratio.high));
  row += number_cell(cell.error_median, scientific(cell.error_median));
  row += number_cell(cell.error_p99, scientific(cell.error_p99));
  row += number_cell(of_solvable(cell.solved_1e6), percent(of_solvable(cell.solved_1e6)));
  row += number_cell(of_solvable(cell.solved_1e9), percent(of_solvable(cell.solved_1e9)));
  row += number_cell(cell.criterion_rate(), percent(cell.criterion_rate()));
  row += number_cell(cell.violation.max, scientific(cell.violation.max));
  return row + "</tr>\n";
}

bool has_sweep(const Summary& summary, const Cell& cell) { return !summary.solvers[cell.solver].sweep.empty(); }

std::string set_table(const Summary& summary, std::size_t set) {
  std::string rows;
  for (const Cell& cell : summary.cells) {
    if (cell.set == set && !has_sweep(summary, cell)) rows += cell_row(summary, cell);
  }
  return rows.empty() ? "" : table_head("cells", kCellColumns) + rows + kTableEnd;
}

std::string settings_detail(const std::string& settings) { return settings.empty() ? "defaults" : code(settings); }

std::string range_cells(const SweepSummary::Range& range) {
  return number_cell(range.worst, percent(range.worst), settings_detail(range.worst_settings)) +
         number_cell(range.average, percent(range.average)) +
         number_cell(range.best, percent(range.best), settings_detail(range.best_settings));
}

std::string sweep_table(const Summary& summary, std::size_t set) {
  constexpr Column kColumns[] = {
      {"Solver, sweep", false}, {"Cells", true}, {"Problems", true},       {"Verdict: worst", true},
      {"average", true},        {"best", true},  {"best, held out", true}, {"Criterion: worst", true},
      {"average", true},        {"best", true}};
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
         table_head("cells", kColumns) + rows + kTableEnd;
}

std::string size_line(const Summary& summary, const SetSummary& set) {
  const std::string n = set.smallest_n == set.largest_n ? std::to_string(set.largest_n)
                                                        : fmt::format("{}–{}", set.smallest_n, set.largest_n);
  const std::string coverage = set_coverage(summary.coverage, set.name);
  return fmt::format("<p class=\"note\">{}; {}, n = {}.{}{}</p>\n", describe(set), counted(set.problems, "problem"), n,
                     set.all_solvable ? " All proven solvable." : "",
                     coverage.empty() ? "" : " <span class=\"bad\">Only " + escape(coverage) + ".</span>");
}

// --- claims ---

const char* claim_words(Claim claim) {
  switch (claim) {
    case Claim::kSolved: return "said solved";
    case Claim::kUnsolvable: return "said unsolvable";
    case Claim::kIterationLimit: return "hit its iteration limit";
    case Claim::kTimeLimit: return "hit the time limit";
    case Claim::kNumericalFailure: return "said numerical failure";
    case Claim::kUnsupported: return "refused it";
    case Claim::kCrashed: return "crashed";
  }
  return "";
}

const char* verdict_words(Verdict verdict) {
  switch (verdict) {
    case Verdict::kSolved: return "solved";
    case Verdict::kWrong: return "wrong";
    case Verdict::kUnsolvable: return "unsolvable";
    case Verdict::kRefused: return "refused";
    case Verdict::kMissed: return "missed";
    case Verdict::kOpen: return "open";
  }
  return "";
}

using Matrix = std::array<std::array<std::int64_t, kVerdicts>, kClaims>;

Matrix matrix_of(const Summary& summary, std::size_t solver) {
  Matrix total{};
  for (const Cell& cell : summary.cells) {
    if (cell.solver != solver) continue;
    for (std::size_t claim = 0; claim < kClaims; ++claim) {
      for (std::size_t verdict = 0; verdict < kVerdicts; ++verdict)
        total[claim][verdict] += cell.counts[claim][verdict];
    }
  }
  return total;
}

std::string matrix_row(Claim claim, const std::array<std::int64_t, kVerdicts>& counts) {
  std::string row = fmt::format("<tr><th scope=\"row\" class=\"line\">{}</th>", claim_words(claim));
  for (std::size_t verdict = 0; verdict < kVerdicts; ++verdict) {
    const std::int64_t count = counts[verdict];
    const bool bad = count > 0 && kAllVerdicts[verdict] == Verdict::kWrong;
    row += fmt::format("<td class=\"number\"><span class=\"{}\">{}</span></td>",
                       bad          ? "bad"
                       : count == 0 ? "zero"
                                    : "",
                       count);
  }
  return row + "</tr>\n";
}

std::string claim_matrix(const Summary& summary, std::size_t solver) {
  const Matrix counts = matrix_of(summary, solver);
  std::string rows;
  for (std::size_t claim = 0; claim < kClaims; ++claim) {
    const bool any = std::any_of(counts[claim].begin(), counts[claim].end(), [](std::int64_t n) { return n > 0; });
    if (any) rows += matrix_row(kAllClaims[claim], counts[claim]);
  }
  if (rows.empty()) return "";
  std::string table = "<div class=\"scroll\" tabindex=\"0\"><table><caption>" + code(summary.solvers[solver].text()) +
                      ", all sets</caption><thead><tr><th scope=\"col\">claim</th>";
  for (const Verdict verdict : kAllVerdicts) {
    table += fmt::format("<th scope=\"col\" class=\"number\">{}</th>", verdict_words(verdict));
  }
  return table + "</tr></thead><tbody>\n" + rows + kTableEnd;
}

// --- times ---

/// Means over all problems of a solver, each set weighted by its trials.
TimeParts mean_parts(const Summary& summary, std::size_t solver) {
  TimeParts total;
  double trials = 0;
  for (const Cell& cell : summary.cells) {
    if (cell.solver != solver || std::isnan(cell.time_parts.solve_cpu)) continue;
    const auto weight = static_cast<double>(cell.trials - cell.count(Claim::kUnsupported));
    trials += weight;
    total.setup_wall += weight * cell.time_parts.setup_wall;
    total.setup_cpu += weight * cell.time_parts.setup_cpu;
    total.solve_wall += weight * cell.time_parts.solve_wall;
    total.solve_cpu += weight * cell.time_parts.solve_cpu;
    total.transport += weight * cell.time_parts.transport;
    total.verify += weight * cell.time_parts.verify;
  }
  return {total.setup_wall / trials, total.setup_cpu / trials, total.solve_wall / trials,
          total.solve_cpu / trials,  total.transport / trials, total.verify / trials};
}

std::string times_table(const Summary& summary) {
  constexpr Column kColumns[] = {{"Solver", false},      {"Set-up, CPU", true}, {"Solve, CPU", true},
                                 {"Set-up, wall", true}, {"Solve, wall", true}, {"Transport", true},
                                 {"Verification", true}};
  std::string rows;
  for (std::size_t solver = 0; solver < summary.solvers.size(); ++solver) {
    const TimeParts parts = mean_parts(summary, solver);
    if (!summary.solvers[solver].sweep.empty() || std::isnan(parts.solve_cpu)) continue;
    rows += "<tr>" + solver_heading(summary.solvers[solver]);
    for (const double part :
         {parts.setup_cpu, parts.solve_cpu, parts.setup_wall, parts.solve_wall, parts.transport, parts.verify}) {
      rows += number_cell(part, part == 0 ? "–" : duration(part));  // no transport within this process
    }
    rows += "</tr>\n";
  }
  return rows.empty() ? "" : table_head("cells", kColumns) + rows + kTableEnd;
}

// --- provenance ---

std::string json_text(const nlohmann::ordered_json& value) {
  if (value.is_string()) return value.get<std::string>();
  return value.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

bool holds_only_scalars(const nlohmann::ordered_json& value) {
  return std::none_of(value.begin(), value.end(), [](const auto& member) { return member.is_structured(); });
}

/// "library Bullet, version 3.24"
std::string members_in_line(const nlohmann::ordered_json& object) {
  std::string line;
  for (const auto& [key, member] : object.items()) line += (line.empty() ? "" : ", ") + key + " " + json_text(member);
  return line;
}

/// One row per member; objects inside are taken apart, down to those that fit in one row.
void add_provenance_rows(const std::string& name, const nlohmann::ordered_json& value, std::string& rows) {
  const bool nested = !name.empty();
  if (value.is_object() && !value.empty() && !(nested && holds_only_scalars(value))) {
    for (const auto& [key, member] : value.items()) {
      add_provenance_rows(nested ? name + "." + key : key, member, rows);
    }
    return;
  }
  const std::string text = value.is_object() ? members_in_line(value) : json_text(value);
  rows += "<tr><th scope=\"row\" class=\"line\">" + escape(name) + "</th><td>" + code(text) + "</td></tr>\n";
}

std::string run_table(const RunSummary& run, bool open) {
  std::string rows;
  nlohmann::ordered_json provenance = run.provenance;
  if (provenance.is_object()) provenance.erase("planned");  // the plan says the same to people
  add_provenance_rows("", provenance, rows);
  return std::string("<details") + (open ? " open" : "") + "><summary>Run of " + escape(run.started) +
         "</summary><div class=\"scroll\" tabindex=\"0\"><table><tbody>\n" + rows + kTableEnd + "</details>\n";
}

std::string run_line(const RunSummary& run) {
  const auto member = [&run](const char* name) {
    const bool present = run.provenance.is_object() && run.provenance.contains(name);
    return present ? json_text(run.provenance[name]) : std::string("not recorded");
  };
  return fmt::format(
      "<p>Latest run: {}, processor {}, instruction-set level {}, seed {}, compiler {}. To repeat it: {}</p>\n",
      escape(run.started), escape(member("processor")), code(member("isa")), escape(member("seed")),
      escape(member("compiler")), code(member("command")));
}

/// Solvers that a run left out, "name: reason", each once.
std::vector<std::string> skipped_solvers(const Summary& summary) {
  std::vector<std::string> skipped;
  for (const RunSummary& run : summary.runs) {
    if (!run.provenance.is_object()) continue;
    const auto list = run.provenance.find("skipped");
    if (list == run.provenance.end() || !list->is_array()) continue;
    for (const auto& entry : *list) {
      const std::string text = json_text(entry);
      if (std::find(skipped.begin(), skipped.end(), text) == skipped.end()) skipped.push_back(text);
    }
  }
  return skipped;
}

std::string skipped_list(const Summary& summary) {
  std::string items;
  for (const std::string& entry : skipped_solvers(summary)) {
    const std::size_t colon = entry.find(": ");
    items += "<li>" + code(entry.substr(0, colon));
    if (colon != std::string::npos) items += ": " + escape(entry.substr(colon + 2));
    items += "</li>\n";
  }
  return items.empty() ? "" : "<p>Solvers left out of a run:</p>\n<ul>\n" + items + "</ul>\n";
}

}  // namespace

std::string sets_section(const Summary& summary, const Figures& figures) {
  if (has_only_hard_sets(summary)) return "";
  std::string section =
      "<section id=\"sets\"><h2>Every set and solver</h2>\n"
      "<p>Small numbers are 95 % intervals. Headings sort. “Solved” is our verdict on the answer, of the problems not "
      "proven unsolvable; what the solver said of itself plays no part in it. The same numbers are in "
      "<code>tables/cells.csv</code> and <code>summary.json</code>.</p>\n";
  if (!summary.reference.empty()) {
    section += "<p>Reference of the time ratios: " + code(summary.reference) +
               ", on the problems that both solved; below 1 is faster.</p>\n";
  }
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    if (is_hard_set(summary.sets[set].name)) continue;
    section += fmt::format("<h3 id=\"set-{}\">{}</h3>\n", set, code(summary.sets[set].name));
    section += size_line(summary, summary.sets[set]) + set_table(summary, set) + sweep_table(summary, set);
    section += figure_html(figures.distribution, set, "");
  }
  if (summary.sets.empty()) section += "<p>The store holds no problems.</p>\n";
  return section + "</section>\n";
}

std::string claims_section(const Summary& summary) {
  std::string section =
      "<section id=\"claims\"><h2>Claim against verdict</h2>\n<p>Rows: what the solver said of its answer. Columns: "
      "what "
      "the answer is, found from the problem’s data alone. Red: said solved, was wrong, or the problem has no "
      "solution. "
      "Every answer is counted once.</p>\n<div class=\"matrices\">\n";
  for (std::size_t solver = 0; solver < summary.solvers.size(); ++solver) {
    if (summary.solvers[solver].sweep.empty()) section += claim_matrix(summary, solver);
  }
  return section + "</div></section>\n";
}

std::string times_section(const Summary& summary) {
  return "<section id=\"times\"><h2>What each time contains</h2>\n"
         "<p><strong>Time per problem</strong> everywhere in this report is set-up plus solve, in CPU time of the "
         "thread "
         "that solves: of this process for native solvers, of the worker process for foreign libraries. CPU time does "
         "not "
         "grow when other programs use the machine; wall time stands beside it below.</p>\n<ul>\n"
         "<li><strong>Set-up</strong>: taking in the problem: forming the matrix M from the contacts’ data, factoring "
         "what does not depend on the velocity, and converting to the library’s own form (row padding, signs, its own "
         "objects). A foreign library pays for its conversion here, as it would in your program.</li>\n"
         "<li><strong>Solve</strong>: from the problem taken in to the answer.</li>\n"
         "<li><strong>Transport</strong>: moving problem and answer to and from a library’s worker process. Wall "
         "clock; in "
         "no time above, as a program that links the library does not have it.</li>\n"
         "<li><strong>Verification</strong>: our check of the answer in 113-bit arithmetic; in no time above.</li>\n"
         "<li>Starting a worker process and generating problems are never timed. Solves too short for the clock are "
         "repeated and averaged. Solvers take turns on each problem, so that a change of the processor’s speed meets "
         "all of them.</li>\n"
         "<li>Mean and median are over all problems that the solver took, failures included; "
         "<code>tables/cells.csv</code> "
         "has the same for the solved ones. A solver that was ended for its time limit or died counts with the time "
         "that was recorded until then.</li>\n</ul>\n"
         "<p class=\"note\">Means over all problems of a solver. Solvers that ran on other sets met other problems: "
         "compare "
         "solvers within a set.</p>\n" +
         times_table(summary) + "</section>\n";
}

std::string provenance_section(const Summary& summary) {
  std::string section = "<section id=\"provenance\"><h2>Provenance</h2>\n";
  if (!summary.runs.empty()) section += run_line(summary.runs.back());
  section += skipped_list(summary);
  for (const RunSummary& run : summary.runs) section += run_table(run, &run == &summary.runs.back());
  if (summary.runs.empty()) section += "<p>The store records no run.</p>\n";
  return section + "</section>\n";
}

std::string definitions_section() {
  return std::string("<section id=\"definitions\"><h2>Definitions</h2>\n<dl>\n") +
         "<dt><strong>Problem</strong></dt><dd>Find impulses z ≥ 0 with w = M z + q ≥ 0 and zᵀw = 0. M and q come from "
         "contact normals N, friction directions D, friction coefficients μ, inertia G and velocity v.</dd>\n"
         "<dt><strong>Error ρ</strong> (relative velocity residual)</dt><dd>The largest amount by which the answer "
         "breaks a row of the problem, as a velocity, over the scale of the row’s island: the smaller of what is "
         "missing in the impulse (turned into a velocity by the row’s own inertia) and in the velocity. An island is "
         "a group of contacts that nothing couples to the others. Its scale is max |q| of its rows, or 1e4 times the "
         "rounding of q where that is more. Computed from the contacts’ data in 113-bit arithmetic, by code that "
         "knows no solver. Problems without contact data use a backward error instead.</dd>\n"
         "<dt><strong>Solved</strong></dt><dd>ρ ≤ 1e-4 (without contact data: backward error ≤ 1e-9), and the problem "
         "is not proven to have no solution. "
         "<strong>Error ≤ 1e-6</strong> and <strong>≤ 1e-9</strong> ask for more.</dd>\n"
         "<dt><strong>Wrong</strong>, or <strong>said solved, was wrong</strong> (false claim)</dt><dd>Said solved, "
         "and is not: ρ is above its limit, there is no answer to measure, or the problem is proven to have no "
         "solution. Passing the paper’s criterion excuses nothing.</dd>\n"
         "<dt><strong>Unsolvable</strong></dt><dd>Not said solved, and a proof that no solution exists was checked in "
         "exact arithmetic.</dd>\n"
         "<dt><strong>Refused</strong></dt><dd>The problem is outside what the solver takes.</dd>\n"
         "<dt><strong>Missed, open</strong></dt><dd>None of these: the problem is known to be solvable (missed), or "
         "nobody knows (open).</dd>\n"
         "<dt><strong>Gave up</strong></dt><dd>Refused, missed and open together: not said solved, not solved, and the "
         "problem is not proven to have no solution. The solver ended at an iteration or time limit, in a numerical "
         "failure or a crash, refused the problem, or said that it has no solution, which is false or not "
         "proven.</dd>\n"
         "<dt><strong>Paper’s criterion</strong></dt><dd>Claimed solved and passes the criterion of Drumwright and "
         "Shell (2012), of all problems: comparable with their solution frequency. It asks for a normal violation "
         "below 1e-3 m/s and a work gain below 1e-3 J, and looks at no friction cone and no complementarity, so that "
         "an answer that ignores friction can pass it. It plays no part in any verdict.</dd>\n"
         "<dt><strong>Intervals</strong></dt><dd>95 %: Wilson’s for shares; bootstrap over problems for medians and "
         "time "
         "ratios. A time ratio is the sum of one solver’s times over the sum of the reference’s, on the problems that "
         "both solved.</dd>\n"
         "<dt><strong>99 %</strong></dt><dd>The smallest value that 99 % of the answers said to be solved do not "
         "exceed; with fewer "
         "than 100 answers it is the largest.</dd>\n"
         "<dt><strong>Reliable, too few to say</strong></dt><dd>" +
         reliability_rule_html() +
         "</dd>\n"
         "<dt><strong>Tie</strong></dt><dd>Both are reliable, and the ratio of their times is within 5 % of 1, or its "
         "interval contains 1.</dd>\n</dl>\n"
         "<p>The files <code>docs/howto/report.md</code> and <code>docs/explanation/verdicts.md</code> of lcpbench say "
         "more.</p></section>\n";
}

std::string limits_section(const Summary& summary) {
  std::string section =
      "<section id=\"limits\"><h2>Limits</h2>\n<ul>\n"
      "<li>The paper’s problems are random and dense; engines meet sparse, structured, repeated ones.</li>\n"
      "<li>Friction is the polyhedral cone of the Anitescu–Potra model. An engine that models friction otherwise is "
      "not "
      "compared on frictional problems.</li>\n"
      "<li>Solvers run from a cold start. Warm starts, which help iterative solvers most, are not measured here.</li>\n"
      "<li>Each solver runs at the settings shown, not at the best it could be tuned to. A sweep shows how much that "
      "matters; its best cell is a maximum, and flatters.</li>\n"
      "<li>Medians hide slow outliers: see mean, deviation and maximum in <code>tables/cells.csv</code>.</li>\n";
  const bool sampled = std::any_of(summary.cells.begin(), summary.cells.end(), [&summary](const Cell& cell) {
    return cell.trials < summary.sets[cell.set].problems;
  });
  if (sampled) {
    section +=
        "<li>Some solvers met only a part of a set’s problems; the number stands with them. Their intervals are "
        "wider for it.</li>\n";
  }
  return section + "</ul></section>\n";
}

}  // namespace lcpbench::report
