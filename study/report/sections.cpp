#include "study/report/sections.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "study/report/html_table.h"
#include "study/report/reliability.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

std::string solver_heading(const SolverRow& solver) {
  std::string detail = escape(solver.library);
  if (solver.library != "native" && !solver.version.empty()) detail += " " + escape(solver.version);
  return "<th scope=\"row\">" + code(solver.text()) + "<small>" + detail + "</small></th>";
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

}  // namespace

std::string claims_section(const Summary& summary) {
  std::string section =
      "<section id=\"claims\"><h2>Claim against verdict</h2>\n<p>Rows: what the solver said of its answer. Columns: "
      "what "
      "the answer is, found from the problem’s data alone. Red: said solved, was wrong, or the problem has no "
      "solution. "
      "Every answer is counted once.</p>\n<details><summary>The solvers, one table each</summary><div "
      "class=\"matrices\">\n";
  for (std::size_t solver = 0; solver < summary.solvers.size(); ++solver) {
    if (summary.solvers[solver].sweep.empty()) section += claim_matrix(summary, solver);
  }
  return section + "</div></details></section>\n";
}

std::string times_section(const Summary& summary) {
  return "<section id=\"times\"><h2>What each time contains</h2>\n"
         "<p><strong>Time per problem</strong> everywhere in this report is set-up plus solve, in CPU time of the "
         "thread "
         "that solves: of this process for native solvers, of the worker process for foreign libraries. CPU time does "
         "not "
         "grow when other programs use the machine; wall time stands beside it below.</p>\n<details><summary>The parts "
         "of a time, and their means</summary>\n<ul>\n"
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
         times_table(summary) + "</details></section>\n";
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
