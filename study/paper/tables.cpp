#include "study/paper/tables.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace lcpbench::paper {

namespace {

/// Rows of the store's parameterisations with the names of set and solver; `condition` narrows them.
std::string counts_by_cell(const std::string& condition) {
  return "SELECT sets.name AS problem_set, solvers.name AS solver, solvers.sweep, solvers.isa, j.cell, j.settings,\n"
         "    COUNT(*) AS trials, SUM(j.claim = 'solved' AND v.criterion = 1) AS criterion,\n"
         "    SUM(j.verdict = 'solved') AS solved, SUM(j.truth = 'unsolvable') AS unsolvable,\n"
         "    solvers.library, solvers.version, SUM(v.criterion = 1) AS criterion_any\n"
         "  FROM judged_cells j JOIN verdicts v USING (problem_id, solver_id, part)\n"
         "    JOIN sets ON sets.id = j.set_id JOIN solvers ON solvers.id = j.solver_id\n"
         "  WHERE " +
         condition + "\n  GROUP BY j.set_id, j.solver_id, j.cell HAVING SUM(j.claim <> 'unsupported') > 0";
}

}  // namespace

using Json = nlohmann::ordered_json;

std::string code(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '`' || c == '\n' || c == '\r'; }, '\'');
  return "`" + text + "`";
}

std::string points(double share) {
  if (std::isnan(share)) return kAbsent;
  const double value = 100 * share;
  if (value == 0 || value == 100) return fmt::format("{:.0f}", value);
  const std::string text = fmt::format("{:.2f}", value);
  if (text == "100.00") return ">99.99";
  if (text == "0.00") return "<0.01";
  return text;
}

std::string points(const Interval& interval) { return points(interval.low) + "–" + points(interval.high); }

std::string number(double value) { return std::isfinite(value) ? fmt::format("{:.3g}", value) : kAbsent; }

std::string spread_text(double mean, double sigma, double max) {
  return number(mean) + " (" + number(sigma) + ") " + number(max);
}

Json share_json(const Proportion& share) {
  return {{"share", share.value()},
          {"low", share.interval().low},
          {"high", share.interval().high},
          {"of", share.trials > 0 ? share.trials : Proportion{}.value()}};
}

const char* words_for(Measure measure) {
  switch (measure) {
    case Measure::kCriterion: return "paper’s criterion";
    case Measure::kCriterionAny: return "criterion, any answer";
    case Measure::kVerdict: break;
  }
  return "our verdict";
}

bool compared_with_paper(const Grid& grid, Kind kind) {
  return grid.problems.kind == kind && grid.problems.other_readings().empty();
}

std::string reading_words(const Experiment& experiment, const std::string& reading) {
  return experiment.redundant ? reading : kAbsent;
}

std::vector<Contestant> contestants(const std::vector<Grid>& grids, Kind kind, const Picks& picks,
                                    const std::vector<Family>& published) {
  std::vector<Contestant> ours;
  for (const Grid& grid : grids) {
    if (!compared_with_paper(grid, kind) || !picks(*grid.problems.experiment)) continue;
    const bool known =
        std::any_of(ours.begin(), ours.end(), [&](const Contestant& c) { return c.label == grid.label; });
    if (!known) ours.push_back({family_of(grid.solver), grid.label});
  }
  std::stable_sort(ours.begin(), ours.end(),
                   [](const Contestant& a, const Contestant& b) { return natural_less(a.label, b.label); });
  std::vector<Contestant> ordered;
  for (const Family family : published) {
    const std::size_t before = ordered.size();
    for (const Contestant& contestant : ours) {
      if (contestant.family == family) ordered.push_back(contestant);
    }
    if (ordered.size() == before) ordered.push_back({family, ""});
  }
  for (const Contestant& contestant : ours) {
    const bool placed =
        contestant.family && std::find(published.begin(), published.end(), *contestant.family) != published.end();
    if (!placed) ordered.push_back(contestant);
  }
  return ordered;
}

std::vector<Family> published_families(Kind kind) {
  std::vector<Family> families;
  for (const Family family : kFamilies) {
    if (published_rate(kind, "exp1", family)) families.push_back(family);
  }
  return families;
}

Entry refused_entry(const Grid& grid) {
  const std::string text = grid.refusal();
  const std::size_t colon = text.find(": ");
  return {text.substr(0, colon), colon == std::string::npos ? "" : text.substr(colon + 2)};
}

std::string why_no_numbers(const Summary& summary, const Contestant& contestant, const Grid* grid) {
  if (grid != nullptr) return grid->refusal();
  return contestant.label.empty() ? why_not_run(summary, *contestant.family) : "not run";
}

bool is_experiment_six(const Experiment& experiment) { return experiment.regularized; }

std::string rates_query(Kind kind) {
  const std::string swept = std::string("solvers.sweep <> '' AND sets.name LIKE 'paper/") + name_of(kind) + "/%'";
  return "WITH counts AS (\n  " + counts_by_cell(swept) +
         ")\n"
         "SELECT problem_set, solver, sweep, isa, COUNT(*) AS parameterisations, MIN(trials) AS trials,\n"
         "  MIN(1.0 * criterion / trials) AS criterion_worst, AVG(1.0 * criterion / trials) AS criterion_average,\n"
         "  MAX(1.0 * criterion / trials) AS criterion_best,\n"
         "  MIN(1.0 * solved / (trials - unsolvable)) AS verdict_worst,\n"
         "  AVG(1.0 * solved / (trials - unsolvable)) AS verdict_average,\n"
         "  MAX(1.0 * solved / (trials - unsolvable)) AS verdict_best, library, version,\n"
         "  MIN(1.0 * criterion_any / trials) AS criterion_any_worst,\n"
         "  AVG(1.0 * criterion_any / trials) AS criterion_any_average,\n"
         "  MAX(1.0 * criterion_any / trials) AS criterion_any_best\n"
         "FROM counts GROUP BY problem_set, solver, sweep, isa, library, version\n"
         "ORDER BY problem_set, solver, sweep, isa, library, version;";
}

std::string cells_query() {
  return counts_by_cell("solvers.sweep <> '' AND sets.name LIKE 'paper/%'") +
         "\n  ORDER BY problem_set, solver, sweep, isa, library, version, j.cell;";
}

std::string measurements_query() {
  return "WITH rows AS (\n"
         "  SELECT sets.name AS problem_set, solvers.name AS solver, solvers.sweep, solvers.isa,\n"
         "    solvers.library, solvers.version, j.claim,\n"
         "    CASE WHEN j.claim <> 'unsupported' THEN t.setup_cpu_s + t.solve_cpu_s END AS time_s,\n"
         "    v.violation_m_per_s AS violation, j.claim = 'solved' AND v.criterion = 1 AS criterion,\n"
         "    v.criterion = 1 AS criterion_any, j.verdict = 'solved' AS solved\n"
         "  FROM judged_cells j JOIN verdicts v USING (problem_id, solver_id, part)\n"
         "    LEFT JOIN timings t USING (problem_id, solver_id, part)\n"
         "    JOIN sets ON sets.id = j.set_id JOIN solvers ON solvers.id = j.solver_id\n"
         "  WHERE solvers.sweep <> '' AND sets.name LIKE 'paper/%')\n"
         "SELECT problem_set, solver, sweep, isa,\n"
         "  COUNT(time_s) AS all_count, AVG(time_s) AS all_mean, MAX(time_s) AS all_max,\n"
         "  COUNT(time_s) FILTER (WHERE criterion) AS criterion_count,\n"
         "  AVG(time_s) FILTER (WHERE criterion) AS criterion_mean,\n"
         "  MAX(time_s) FILTER (WHERE criterion) AS criterion_max,\n"
         "  COUNT(time_s) FILTER (WHERE solved) AS verdict_count,\n"
         "  AVG(time_s) FILTER (WHERE solved) AS verdict_mean, MAX(time_s) FILTER (WHERE solved) AS verdict_max,\n"
         "  COUNT(violation) FILTER (WHERE criterion) AS criterion_violation_count,\n"
         "  AVG(violation) FILTER (WHERE criterion) AS criterion_violation_mean,\n"
         "  MAX(violation) FILTER (WHERE criterion) AS criterion_violation_max,\n"
         "  AVG(violation) FILTER (WHERE solved) AS verdict_violation_mean,\n"
         "  MAX(violation) FILTER (WHERE solved) AS verdict_violation_max,\n"
         "  library, version,\n"
         "  COUNT(time_s) FILTER (WHERE criterion_any) AS criterion_any_count,\n"
         "  AVG(time_s) FILTER (WHERE criterion_any) AS criterion_any_mean,\n"
         "  MAX(time_s) FILTER (WHERE criterion_any) AS criterion_any_max,\n"
         "  AVG(violation) FILTER (WHERE criterion_any) AS criterion_any_violation_mean,\n"
         "  MAX(violation) FILTER (WHERE criterion_any) AS criterion_any_violation_max\n"
         "FROM rows GROUP BY problem_set, solver, sweep, isa, library, version\n"
         "HAVING SUM(claim <> 'unsupported') > 0 ORDER BY problem_set, solver, sweep, isa, library, version;";
}

std::string totals_query() {
  return "SELECT sets.name AS problem_set, solvers.name AS solver, solvers.sweep, j.settings, COUNT(*) AS trials,\n"
         "  SUM(j.claim = 'solved' AND v.criterion = 1) AS criterion, SUM(j.verdict = 'solved') AS solved,\n"
         "  SUM(j.truth = 'unsolvable') AS unsolvable,\n"
         "  SUM(j.verdict = 'wrong') AS false_claims\n"
         "FROM judged_cells j JOIN verdicts v USING (problem_id, solver_id, part)\n"
         "  JOIN sets ON sets.id = j.set_id JOIN solvers ON solvers.id = j.solver_id\n"
         "WHERE sets.name LIKE 'paper/%'\n"
         "GROUP BY j.set_id, j.solver_id, j.cell HAVING SUM(j.claim <> 'unsupported') > 0\n"
         "ORDER BY problem_set, solver, solvers.sweep, j.cell;";
}

}  // namespace lcpbench::paper
