#pragma once

#include <array>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "study/report/reliability.h"
#include "study/report/solver_comparison.h"

namespace lcpbench::report {

/// An estimate as the members "value", "low" and "high".
nlohmann::ordered_json estimate_json(const Estimate& estimate);

/// A share as the members "count", "of", "share", and its interval "low" and "high".
nlohmann::ordered_json share_json(const Share& share);

/// The comparison tables as arrays of records, by name: "mcnemar", "solver_times", "ecdf", "profiles", "vbs", "chains".
/// Numbers that are none are NaN, which JSON writes as null.
nlohmann::ordered_json comparison_tables(const Summary& summary, const std::vector<SetComparison>& comparisons);

/// A comparison with one of everything: its records have the names of every table's columns.
SetComparison example_comparison();

/// The tables with what they were made with (shift, time limit, significance), as summary.json holds them; the long
/// one, "ecdf", is left to its CSV file.
nlohmann::ordered_json comparison_json(const Summary& summary, const std::vector<SetComparison>& comparisons);

/// A query on the store, for any SQLite shell, that repeats a table's counts.
struct CountQuery {
  const char* tables;  ///< which
  const char* sql;
};

/// One row per set and solver: "set", "solver", "isa", "problems", "solved", "within_1ms", "error_1e6".
inline constexpr CountQuery kSolverCounts{"solver_times.csv and ecdf.csv (here at 1 ms and at an error of 1e-6)", R"sql(
SELECT sets.name AS "set", s.name || iif(s.settings = '', '', '{' || s.settings || '}') AS solver, s.isa,
       COUNT(*) AS problems,
       COUNT(*) FILTER (WHERE j.verdict = 'solved') AS solved,
       COUNT(*) FILTER (WHERE j.verdict = 'solved' AND t.setup_cpu_s + t.solve_cpu_s <= 1e-3) AS within_1ms,
       COUNT(*) FILTER (WHERE coalesce(v.velocity_residual_relative, v.backward_row_norm) <= 1e-6) AS error_1e6
FROM judged j JOIN solvers s ON s.id = j.solver_id JOIN sets ON sets.id = j.set_id
     JOIN verdicts v USING (problem_id, solver_id, part) LEFT JOIN timings t USING (problem_id, solver_id, part)
WHERE s.sweep = '' AND j.truth <> 'unsolvable' AND j.verdict <> 'unsolvable'
GROUP BY j.set_id, j.solver_id ORDER BY 1, 2, 3;
)sql"};

/// One row per set and ordered pair: "set", "first", "second", "problems", "both", "only_first", "only_second",
/// "neither".
inline constexpr CountQuery kPairCounts{"mcnemar.csv", R"sql(
WITH met AS MATERIALIZED (
  SELECT j.set_id, j.problem_id, j.solver_id, j.verdict = 'solved' AS solved,
         j.truth = 'unsolvable' OR j.verdict = 'unsolvable' AS unsolvable,
         s.name || iif(s.settings = '', '', '{' || s.settings || '}') AS solver
  FROM judged j JOIN solvers s ON s.id = j.solver_id
  WHERE s.sweep = '' AND j.claim <> 'unsupported')
SELECT sets.name AS "set", a.solver AS first, b.solver AS second, COUNT(*) AS problems,
       SUM(a.solved AND b.solved) AS both, SUM(a.solved > b.solved) AS only_first,
       SUM(a.solved < b.solved) AS only_second, SUM(NOT a.solved AND NOT b.solved) AS neither
FROM met a JOIN met b ON b.problem_id = a.problem_id AND b.solver_id <> a.solver_id
     AND b.unsolvable = a.unsolvable JOIN sets ON sets.id = a.set_id
GROUP BY a.set_id, a.solver_id, b.solver_id ORDER BY 1, 2, 3;
)sql"};

/// One row per set and ordered pair: "set", "solver", "against", "problems", "within_2": problems that `solver` solved
/// within twice the time of the faster of the two.
inline constexpr CountQuery kProfileCounts{"profiles.csv (here at a factor of 2)", R"sql(
WITH met AS MATERIALIZED (
  SELECT j.set_id, j.problem_id, j.solver_id,
         s.name || iif(s.settings = '', '', '{' || s.settings || '}') AS solver,
         iif(j.verdict = 'solved', t.setup_cpu_s + t.solve_cpu_s, 9e999) AS time_s
  FROM judged j JOIN solvers s ON s.id = j.solver_id LEFT JOIN timings t USING (problem_id, solver_id, part)
  WHERE s.sweep = '' AND j.claim <> 'unsupported' AND j.truth <> 'unsolvable'
        AND j.verdict <> 'unsolvable')
SELECT sets.name AS "set", a.solver, b.solver AS against, COUNT(*) AS problems,
       COUNT(*) FILTER (WHERE a.time_s < 9e999 AND a.time_s / min(a.time_s, b.time_s) <= 2) AS within_2
FROM met a JOIN met b ON b.problem_id = a.problem_id AND b.solver_id <> a.solver_id JOIN sets ON sets.id = a.set_id
WHERE a.time_s IS NOT NULL AND b.time_s IS NOT NULL
GROUP BY a.set_id, a.solver_id, b.solver_id ORDER BY 1, 2, 3;
)sql"};

/// One row per set and solver that met all of its problems: "set", "solver", "problems", "virtual_best", "solved",
/// "alone".
inline constexpr CountQuery kPortfolioCounts{"vbs.csv (rows with scope “all problems”)", R"sql(
WITH met AS MATERIALIZED (
  SELECT j.set_id, j.problem_id, j.solver_id, j.verdict, j.truth, j.claim,
         s.name || iif(s.settings = '', '', '{' || s.settings || '}') AS solver
  FROM judged j JOIN solvers s ON s.id = j.solver_id WHERE s.sweep = ''),
complete AS MATERIALIZED (
  SELECT m.set_id, m.solver_id FROM met m GROUP BY m.set_id, m.solver_id
  HAVING COUNT(*) = (SELECT COUNT(*) FROM problems p WHERE p.set_id = m.set_id)
     AND COUNT(*) > COUNT(*) FILTER (WHERE m.claim = 'unsupported')),
by_problem AS MATERIALIZED (
  SELECT problem_id, SUM(verdict = 'solved') AS solvers
  FROM met JOIN complete USING (set_id, solver_id)
  WHERE problem_id NOT IN (SELECT problem_id FROM met WHERE truth = 'unsolvable' OR verdict = 'unsolvable')
  GROUP BY problem_id)
SELECT sets.name AS "set", met.solver, COUNT(*) AS problems, SUM(b.solvers > 0) AS virtual_best,
       SUM(met.verdict = 'solved') AS solved, SUM(met.verdict = 'solved' AND b.solvers = 1) AS alone
FROM met JOIN complete USING (set_id, solver_id) JOIN by_problem b USING (problem_id)
     JOIN sets ON sets.id = met.set_id
GROUP BY met.set_id, met.solver_id ORDER BY 1, 2;
)sql"};

inline constexpr std::array<CountQuery, 4> kCountQueries{kPairCounts, kSolverCounts, kProfileCounts, kPortfolioCounts};

/// How many problems of the set the solvers of a chain solved together: one query, one number. @pre there is a chain.
std::string chain_query(const Summary& summary, std::size_t set, const FallbackChain& chain);

}  // namespace lcpbench::report
