#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "study/output/text_table.h"
#include "study/report/page.h"
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
  std::vector<Column> columns{{"claim"}};
  for (const Verdict verdict : kAllVerdicts) columns.push_back({to_string(verdict), true});
  return table_head("", columns, code(summary.solvers[solver].text()) + ", all sets") + rows + kTableEnd;
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
    for (const auto part : kTimeParts) total.*part += weight * cell.time_parts.*part;
  }
  for (const auto part : kTimeParts) total.*part /= trials;
  return total;
}

std::string times_table(const Summary& summary) {
  const std::vector<Column> columns{
      {"Solver"},          {"Set-up, CPU", true}, {"Solve, CPU", true}, {"Set-up, wall", true}, {"Solve, wall", true},
      {"Transport", true}, {"Verification", true}};
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
  return rows.empty() ? "" : table_head("cells", columns) + rows + kTableEnd;
}

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

std::string full_record(const RunSummary& run) {
  std::string rows;
  nlohmann::ordered_json provenance = run.provenance;
  if (provenance.is_object()) provenance.erase("planned");  // the plan says the same to people
  add_provenance_rows("", provenance, rows);
  return "<details><summary>The full record of the run of " + escape(run.started) + "</summary>" + table_head("", {}) +
         rows + kTableEnd + "</details>\n";
}

std::string joined(const std::vector<std::string>& values) {
  std::string text;
  for (const std::string& value : values) text += (text.empty() ? "" : "; ") + escape(value);
  return text;
}

/// "2026-01-31 12:00 UTC" of "2026-01-31T12:00:00Z"; other texts as they are.
std::string minute_of(const std::string& started) {
  const bool known = started.size() == 20 && started[10] == 'T' && started.back() == 'Z';
  return known ? started.substr(0, 10) + " " + started.substr(11, 5) + " UTC" : started;
}

std::string when(const Summary& summary) {
  const std::string first = minute_of(summary.runs.front().started);
  const std::string last = minute_of(summary.runs.back().started);
  if (summary.runs.size() == 1) return escape(first);
  return fmt::format("{} runs, begun from {} to {}", summary.runs.size(), escape(first), escape(last));
}

std::string size_words(const Summary& summary) {
  std::int64_t problems = 0;
  std::int64_t answers = 0;
  for (const SetSummary& set : summary.sets) problems += set.problems;
  for (const Cell& cell : summary.cells) answers += cell.trials;
  return fmt::format("{} problems of {}, {} solvers and settings, {} answers", format_count(problems),
                     counted(std::ssize(summary.sets), "set"), format_count(std::ssize(summary.solvers)),
                     format_count(answers));
}

std::string fact(const char* name, const std::string& value) {
  return std::string("<tr><th scope=\"row\" class=\"line\">") + name + "</th><td>" + value + "</td></tr>\n";
}

std::string facts(const Summary& summary) {
  const auto recorded = [&summary](const char* name) { return joined(recorded_values(summary, name)); };
  return table_head("facts", {}) + fact("When", when(summary)) + fact("How much", size_words(summary)) +
         fact("Machine", recorded("processor") + ", cores: " + recorded("cores") + ", " + recorded("os")) +
         fact("Instruction-set level", recorded("isa")) +
         fact("Compiler", recorded("compiler") + ", " + recorded("build_type")) +
         fact("lcpbench", recorded("lcpbench") + ", commit " + recorded("commit")) + fact("Seed", recorded("seed")) +
         fact("To repeat it", code(recorded_values(summary, "command").back())) + kTableEnd;
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

std::string claims_section(const Report& report) {
  const Summary& summary = report.summary;
  std::string section =
      "<section id=\"claims\"><h2>Claim against verdict</h2>\n<p>Rows: what the solver said of its answer. Columns: "
      "what the answer is, found from the problem’s data alone. Red: said solved, was wrong, or the problem has no "
      "solution. Every answer is counted once.</p>\n<details><summary>The solvers, one table each</summary><div "
      "class=\"matrices\">\n";
  for (std::size_t solver = 0; solver < summary.solvers.size(); ++solver) {
    if (summary.solvers[solver].sweep.empty()) section += claim_matrix(summary, solver);
  }
  return section + "</div></details></section>\n";
}

std::string times_section(const Report& report) {
  const Summary& summary = report.summary;
  return "<section id=\"times\"><h2>What each time contains</h2>\n"
         "<p><strong>Time per problem</strong> everywhere in this report is set-up plus solve, in CPU time of the "
         "thread that solves: of this process for native solvers, of the worker process for foreign libraries. CPU "
         "time does not grow when other programs use the machine; wall time stands beside it "
         "below.</p>\n<details><summary>The parts of a time, and their means</summary>\n<ul>\n"
         "<li><strong>Set-up</strong>: taking in the problem: forming the matrix M from the contacts’ data, factoring "
         "what does not depend on the velocity, and converting to the library’s own form (row padding, signs, its own "
         "objects). A foreign library pays for its conversion here, as it would in your program.</li>\n"
         "<li><strong>Solve</strong>: from the problem taken in to the answer.</li>\n"
         "<li><strong>Transport</strong>: moving problem and answer to and from a library’s worker process. Wall "
         "clock; in no time above, as a program that links the library does not have it.</li>\n"
         "<li><strong>Verification</strong>: our check of the answer from the data, with rounding bounded; in 113 bits "
         "where that leaves a doubt. In no time above.</li>\n"
         "<li>Starting a worker process and generating problems are never timed. Solves too short for the clock are "
         "repeated and averaged. Solvers take turns on each problem, so that a change of the processor’s speed meets "
         "all of them.</li>\n"
         "<li>Mean and median are over all problems that the solver took, failures included; "
         "<code>tables/cells.csv</code> has the same for the solved ones. A solver that was ended for its time limit "
         "or died counts with the time that was recorded until then.</li>\n</ul>\n"
         "<p class=\"note\">Means over all problems of a solver. Solvers that ran on other sets met other problems: "
         "compare solvers within a set.</p>\n" +
         times_table(summary) + "</details></section>\n";
}

std::string definitions_section(const Report&) {
  return std::string(
             "<details><summary>Definitions: what the words of this page mean</summary>\n<section "
             "id=\"definitions\"><h2>Definitions</h2>\n<dl>\n") +
         "<dt><strong>Problem</strong></dt><dd>Find impulses z ≥ 0 with w = M z + q ≥ 0 and zᵀw = 0. M and q come from "
         "contact normals N, friction directions D, friction coefficients μ, inertia G and velocity v.</dd>\n"
         "<dt><strong>Error ρ</strong> (relative velocity residual)</dt><dd>The largest amount by which the answer "
         "breaks a row of the problem, as a velocity, over the scale of the row’s island: the smaller of what is "
         "missing in the impulse (turned into a velocity by the row’s own inertia) and in the velocity. An island is "
         "a group of contacts that nothing couples to the others. Its scale is max |q| of its rows, or 1e4 times the "
         "rounding of q where that is more. Computed from the contacts’ data with rounding bounded, and in 113 "
         "bits where that leaves a doubt, by code that knows no solver. Problems without contact data use a backward "
         "error instead.</dd>\n"
         "<dt><strong>Solved</strong></dt><dd>ρ ≤ 1e-4 (without contact data: backward error ≤ 1e-9), and the problem "
         "is not proven to have no solution. <strong>Error ≤ 1e-6</strong> and <strong>≤ 1e-9</strong> ask for "
         "more.</dd>\n"
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
         "time ratios. A time ratio is the sum of one solver’s times over the sum of the reference’s, on the problems "
         "that both solved.</dd>\n"
         "<dt><strong>99 %</strong></dt><dd>The smallest value that 99 % of the answers said to be solved do not "
         "exceed; with fewer than 100 answers it is the largest.</dd>\n"
         "<dt><strong>Reliable, too few to say</strong></dt><dd>" +
         reliability_rule_html() +
         "</dd>\n"
         "<dt><strong>Tie</strong></dt><dd>Both are reliable, and the ratio of their times is within 5 % of 1, or its "
         "interval contains 1.</dd>\n</dl>\n"
         "<p>The files <code>docs/howto/report.md</code> and <code>docs/explanation/verdicts.md</code> of lcpbench say "
         "more.</p></section>\n</details>\n";
}

std::string limits_section(const Report& report) {
  const Summary& summary = report.summary;
  std::string section =
      "<section id=\"limits\"><h2>Limits</h2>\n<ul>\n"
      "<li>The paper’s problems are random and dense; engines meet sparse, structured, repeated ones.</li>\n"
      "<li>Friction is the polyhedral cone of the Anitescu–Potra model. An engine that models friction otherwise is "
      "not compared on frictional problems.</li>\n"
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

std::string recorded_value(const RunSummary& run, const char* name) {
  const bool present = run.provenance.is_object() && run.provenance.contains(name);
  return present ? json_text(run.provenance[name]) : "not recorded";
}

std::vector<std::string> recorded_values(const Summary& summary, const char* name) {
  std::vector<std::string> values;
  for (const RunSummary& run : summary.runs) {
    const std::string value = recorded_value(run, name);
    if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
  }
  return values;
}

std::string provenance_section(const Report& report) {
  const Summary& summary = report.summary;
  std::string section = "<section id=\"provenance\"><h2>Provenance</h2>\n";
  if (summary.runs.empty()) return section + "<p>The store records no run.</p>\n</section>\n";
  section += facts(summary) + skipped_list(summary) + full_record(summary.runs.back());
  if (summary.runs.size() > 1) {
    section +=
        "<p class=\"note\">The records of all runs are in <code>summary.json</code>, "
        "<code>provenance.runs</code>.</p>\n";
  }
  return section + "</section>\n";
}

}  // namespace lcpbench::report
