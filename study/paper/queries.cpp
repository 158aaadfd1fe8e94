#include "study/paper/queries.h"

namespace lcpbench::paper {

namespace {

/// Rows of the store's parameterisations with the names of set and solver; `condition` narrows them.
std::string counts_by_cell(const std::string& condition) {
  return "SELECT sets.name AS problem_set, solvers.name AS solver, solvers.sweep, solvers.isa, j.cell, j.settings,\n"
         "    COUNT(*) AS trials, SUM(j.claim = 'solved' AND v.criterion = 1) AS criterion,\n"
         "    SUM(j.verdict = 'solved') AS solved, SUM(j.truth = 'unsolvable') AS unsolvable,\n"
         "    solvers.library, solvers.version\n"
         "  FROM judged_cells j JOIN verdicts v USING (problem_id, solver_id, part)\n"
         "    JOIN sets ON sets.id = j.set_id JOIN solvers ON solvers.id = j.solver_id\n"
         "  WHERE " +
         condition + "\n  GROUP BY j.set_id, j.solver_id, j.cell HAVING SUM(j.claim <> 'unsupported') > 0";
}

}  // namespace

std::string rates_query(Kind kind) {
  const std::string swept = std::string("solvers.sweep <> '' AND sets.name LIKE 'paper/") + name_of(kind) + "/%'";
  return "WITH counts AS (\n  " + counts_by_cell(swept) +
         ")\n"
         "SELECT problem_set, solver, sweep, isa, COUNT(*) AS parameterisations, MIN(trials) AS trials,\n"
         "  MIN(1.0 * criterion / trials) AS criterion_worst, AVG(1.0 * criterion / trials) AS criterion_average,\n"
         "  MAX(1.0 * criterion / trials) AS criterion_best,\n"
         "  MIN(1.0 * solved / (trials - unsolvable)) AS verdict_worst,\n"
         "  AVG(1.0 * solved / (trials - unsolvable)) AS verdict_average,\n"
         "  MAX(1.0 * solved / (trials - unsolvable)) AS verdict_best, library, version\n"
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
         "    j.verdict = 'solved' AS solved\n"
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
         "  library, version\n"
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
