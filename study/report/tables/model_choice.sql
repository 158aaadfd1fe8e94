-- The model of friction that a captured step needs for 1e-3 m/s
-- Each step with friction gets the first of auto, cone_ipm{cone=true,error=0.001} and cone_ipm{cone=true} whose measured error against the round Coulomb cone is at most 1e-3 m/s, each build for itself; met is 0 where none is, and the most accurate one stands. spent_s counts the solvers tried before it too.
-- only in tables/
WITH models(place, name, settings) AS (
  VALUES (1, 'auto', ''), (2, 'cone_ipm', 'cone=true,error=0.001'), (3, 'cone_ipm', 'cone=true')),
tried AS (
  SELECT f.name AS "set", p.trial, p.id, r.place, v.model_error_m_per_s AS error, t.setup_cpu_s + t.solve_cpu_s
           AS time_s, r.name || iif(r.settings = '', '', '{' || r.settings || '}') AS solver, s.isa, s.version
  FROM set_facts f CROSS JOIN sets ON sets.name = f.name CROSS JOIN problems p ON p.set_id = sets.id
  CROSS JOIN models r CROSS JOIN solvers s ON s.name = r.name AND s.settings = r.settings AND s.sweep = ''
  JOIN verdicts v ON v.problem_id = p.id AND v.solver_id = s.id
  LEFT JOIN timings t USING (problem_id, solver_id, part)
  WHERE f.frictional AND f.engine IS NOT NULL),
-- Of the aggregate MIN alone SQLite takes the other columns from the row that has it.
chosen AS (
  SELECT "set", trial, isa, version, solver, error, place, time_s, MIN(iif(error <= 0.001, place, 10 + error)) AS rank,
         SUM(iif(place = 1, time_s, NULL)) AS s1, SUM(iif(place <= 2, time_s, NULL)) AS s2, SUM(time_s) AS s3
  FROM tried GROUP BY "set", trial, id, isa, version
  HAVING SUM(place = 1))
SELECT "set", trial, solver, error AS error_m_per_s, error <= 0.001 AS met, time_s,
       iif(error > 0.001, s3, CASE place WHEN 1 THEN s1 WHEN 2 THEN s2 ELSE s3 END) AS spent_s, s1 AS coarsest_s,
       isa, version
FROM chosen WHERE rank IS NOT NULL AND EXISTS (SELECT 1 FROM tried WHERE place > 1)
ORDER BY "set", trial, isa, version
