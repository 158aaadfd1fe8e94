DROP TABLE IF EXISTS temp.paper_pairs;
-- Solvers at single settings in pairs, on the problems that both took and that are not proven unsolvable: lemke with
-- another solver of the paper on one set, and a regularised solver on Experiment 6 with what it wraps on the same
-- problems, Experiment 5.
CREATE TEMP TABLE paper_pairs AS
WITH singles AS (
  SELECT c.*, s.id AS set_id, v.id AS solver_id
  FROM paper_cells c JOIN sets s ON s.name = c."set"
  JOIN solvers v ON v.name = c.name AND v.sweep = '' AND iif(v.settings = '', 'defaults', v.settings) = c.settings
                    AND v.isa = c.isa AND v.library || ' ' || v.version = c.build
  WHERE c.sweep = '' AND c.other_readings = '' AND c.refused < c.trials),
pairs AS (
  SELECT f.kind, f.experiment, f.redundancy, f.reading, f.other_readings, f.paper_solver, f."set", f.spec AS solver, f.isa,
         s.spec AS second, f.set_id, f.solver_id, s.set_id AS other_set, s.solver_id AS other_solver
  FROM singles f JOIN singles s
    ON s.kind = f.kind AND s.reading = f.reading AND (s.isa = f.isa OR s.isa = '' OR f.isa = '')
       AND iif(f.spec = 'lemke', s.experiment = f.experiment AND s.paper_solver IN ('PATH', 'IP'),
               f.experiment LIKE 'exp6%' AND s.experiment = 'exp5' || substr(f.experiment, 5) AND s.spec = f.wrapped)),
-- Each verdict is computed once. That of a problem without solution is "unsolvable", or "wrong" of a false claim.
met AS MATERIALIZED (
  SELECT pairs.*,
         CASE x.verdict WHEN 'solved' THEN 1 WHEN 'unsolvable' THEN NULL
           WHEN 'wrong' THEN iif(x.truth = 'unsolvable', NULL, 0) ELSE 0 END AS first_solved,
         CASE y.verdict WHEN 'solved' THEN 1 WHEN 'unsolvable' THEN NULL
           WHEN 'wrong' THEN iif(y.truth = 'unsolvable', NULL, 0) ELSE 0 END AS second_solved
  FROM pairs CROSS JOIN problems p CROSS JOIN problems q CROSS JOIN judged x CROSS JOIN judged y
  WHERE p.set_id = pairs.set_id AND q.set_id = other_set AND q.seed = p.seed AND q.trial = p.trial
    AND x.problem_id = p.id AND x.solver_id = pairs.solver_id AND y.problem_id = q.id AND y.solver_id = other_solver
    AND 'unsupported' NOT IN (x.claim, y.claim))
SELECT kind, experiment, redundancy, reading, other_readings, paper_solver, "set", solver, isa, second,
       COUNT(*) AS problems, SUM(first_solved AND NOT second_solved) AS only_first,
       SUM(second_solved AND NOT first_solved) AS only_second
FROM met WHERE first_solved IS NOT NULL AND second_solved IS NOT NULL
GROUP BY kind, experiment, reading, "set", solver, isa, second;
