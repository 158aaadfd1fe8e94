-- The model of friction that a captured step needs for 1e-3 m/s
-- Each step with friction gets the first of auto, cone_ipm{cone=true,error=0.001} and cone_ipm{cone=true} whose measured error against the round Coulomb cone is at most 1e-3 m/s; met is 0 where none is, and the most accurate one stands. spent_s counts the solvers tried before it too.
-- only in tables/
WITH models(place, name, settings) AS (
  VALUES (1, 'auto', ''), (2, 'cone_ipm', 'cone=true,error=0.001'), (3, 'cone_ipm', 'cone=true')),
tried AS (
  SELECT p.id, f.name AS "set", p.trial, r.place, v.model_error_m_per_s AS error, t.setup_cpu_s + t.solve_cpu_s AS time_s,
         r.name || iif(r.settings = '', '', '{' || r.settings || '}') AS solver
  FROM models r JOIN solvers s ON s.name = r.name AND s.settings = r.settings AND s.sweep = ''
  JOIN set_facts f ON f.frictional AND f.engine IS NOT NULL
  JOIN sets ON sets.name = f.name JOIN problems p ON p.set_id = sets.id
  JOIN answers a ON a.problem_id = p.id AND a.solver_id = s.id
  JOIN verdicts v USING (problem_id, solver_id, part) LEFT JOIN timings t USING (problem_id, solver_id, part)),
ranked AS (
  SELECT *, ROW_NUMBER() OVER (PARTITION BY id ORDER BY error > 0.001, iif(error <= 0.001, place, error)) AS rank
  FROM tried WHERE error IS NOT NULL)
SELECT c."set", c.trial, c.solver, c.error AS error_m_per_s, c.error <= 0.001 AS met, c.time_s,
       (SELECT SUM(time_s) FROM tried t WHERE t.id = c.id AND (t.place <= c.place OR c.error > 0.001)) AS spent_s,
       (SELECT time_s FROM tried t WHERE t.id = c.id AND t.place = 1) AS coarsest_s
FROM ranked c
WHERE c.rank = 1 AND EXISTS (SELECT 1 FROM tried t WHERE t.id = c.id AND t.place = 1)
  AND (SELECT COUNT(DISTINCT place) FROM tried) > 1
ORDER BY c."set", c.trial
