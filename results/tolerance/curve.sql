-- Share solved within an error, and the time that it took
-- A solver has run at several tolerances: of each problem the quickest run within the error counts. Errors are the
-- verdict's, of the solver's own model of friction. factor: over the reference, on the problems that both solved.
WITH runs AS (
  SELECT j.problem_id, j.model, x.velocity_residual_relative AS error, t.setup_cpu_s + t.solve_cpu_s AS time_s,
         v.name || '{' || rtrim(replace(replace(v.settings,
             'tolerance=' || coalesce(spec_option(v.spec, 'tolerance'), ''), ''),
             'error=' || coalesce(spec_option(v.spec, 'error'), ''), ''), ',') || '}' AS solver
  FROM judged j JOIN verdicts x USING (problem_id, solver_id, part) JOIN timings t USING (problem_id, solver_id, part)
  JOIN (SELECT *, name || '{' || settings || '}' AS spec FROM solvers) v ON v.id = j.solver_id
  JOIN answers a USING (problem_id, solver_id, part) WHERE a.claim <> 'unsupported'),
errors(bound) AS (VALUES (1e-3), (1e-4), (1e-5), (1e-6), (1e-7), (1e-8), (1e-9), (1e-10), (1e-11), (1e-12)),
taken AS (SELECT solver, model, COUNT(DISTINCT problem_id) AS problems FROM runs GROUP BY 1),
best AS (SELECT solver, model, bound, problem_id, MIN(time_s) AS time_s FROM runs JOIN errors ON error <= bound
         GROUP BY 1, 2, 3, 4)
SELECT t.model, t.solver, e.bound AS error, COUNT(b.problem_id) AS solved, t.problems AS "of",
       1.0 * COUNT(b.problem_id) / t.problems AS share, exp(avg(ln(b.time_s))) AS mean_time_s,
       exp(avg(ln(b.time_s / r.time_s))) AS factor, COUNT(r.problem_id) AS compared
FROM taken t JOIN errors e LEFT JOIN best b ON b.solver = t.solver AND b.bound = e.bound
LEFT JOIN best r ON r.problem_id = b.problem_id AND r.bound = b.bound AND r.solver =
  CASE t.model WHEN 'pyramid' THEN 'auto{}' WHEN 'cone' THEN 'cone_ipm{cone=true}' ELSE 'cone_ipm{cone=true,slip=none}' END
GROUP BY 1, 2, 3 ORDER BY 1, 2, 3 DESC
