-- The model of friction that a captured step needs for 1e-3 m/s
-- Each step with friction gets the first of auto, cone_ipm{cone=true,error=0.001} and cone_ipm{cone=true} whose measured error against the round Coulomb cone is at most 1e-3 m/s; met is 0 where none is, and the most accurate one stands. spent_s counts the solvers tried before it too.
-- only in tables/
WITH models(place, name, settings) AS (
  VALUES (1, 'auto', ''), (2, 'cone_ipm', 'cone=true,error=0.001'), (3, 'cone_ipm', 'cone=true')),
tried AS MATERIALIZED (
  SELECT p.id, f.name AS "set", p.trial, r.place, v.model_error_m_per_s AS error, t.setup_cpu_s + t.solve_cpu_s AS time_s,
         r.name || iif(r.settings = '', '', '{' || r.settings || '}') AS solver
  FROM set_facts f CROSS JOIN sets ON sets.name = f.name CROSS JOIN problems p ON p.set_id = sets.id
  CROSS JOIN models r CROSS JOIN solvers s ON s.name = r.name AND s.settings = r.settings AND s.sweep = ''
  JOIN answers a ON a.problem_id = p.id AND a.solver_id = s.id
  JOIN verdicts v USING (problem_id, solver_id, part) LEFT JOIN timings t USING (problem_id, solver_id, part)
  WHERE f.frictional AND f.engine IS NOT NULL),
summed AS (
  SELECT *, SUM(time_s) OVER (PARTITION BY id ORDER BY place) AS until_s, SUM(time_s) OVER (PARTITION BY id) AS all_s,
         MAX(iif(place = 1, time_s, NULL)) OVER (PARTITION BY id) AS coarsest_s,
         MIN(place) OVER (PARTITION BY id) AS coarsest
  FROM tried),
ranked AS (
  SELECT *, ROW_NUMBER() OVER (PARTITION BY id ORDER BY error > 0.001, iif(error <= 0.001, place, error)) AS rank
  FROM summed WHERE error IS NOT NULL)
SELECT "set", trial, solver, error AS error_m_per_s, error <= 0.001 AS met, time_s,
       iif(error > 0.001, all_s, until_s) AS spent_s, coarsest_s
FROM ranked WHERE rank = 1 AND coarsest = 1 AND (SELECT COUNT(DISTINCT place) FROM tried) > 1
ORDER BY "set", trial
