-- Solvers at single settings in pairs, on the problems that both took and that are not proven unsolvable: on each set
-- lemke with PATH and IP, themselves or regularised; and a regularised solver on Experiment 6 with the solver that it
-- wraps on Experiment 5, which has the same problems. Two native solvers are paired only within one build and
-- instruction-set level. Sets take part if they have no option but the kind of redundancy (column `reading`). The view
-- `pairs` is in study/report/views.sql.
CREATE TEMP TABLE paper_pairs AS
WITH singles AS (
  SELECT c.*, s.id AS set_id, v.id AS solver_id
  FROM paper_cells c JOIN sets s ON s.name = c."set"
  JOIN solvers v ON v.name = c.name AND v.sweep = '' AND iif(v.settings = '', 'defaults', v.settings) = c.settings
                    AND v.isa = c.isa AND v.library || ' ' || v.version = c.build
  WHERE c.sweep = '' AND c.other_readings = '' AND c.refused < c.trials),
named AS (
  SELECT f.kind, f.experiment, f.redundancy, f.reading, f.other_readings, f.paper_solver, f."set", f.spec AS solver,
         f.isa, f.build, s.spec AS second, s.isa AS second_isa, s.build AS second_build, f.full_name AS a,
         s.full_name AS b, f.set_id, f.solver_id, s.set_id AS other_set, s.solver_id AS other_solver
  FROM singles f JOIN singles s
    ON s.kind = f.kind AND s.reading = f.reading
       AND (s.isa = '' OR f.isa = '' OR (s.isa = f.isa AND s.build = f.build))
       AND iif(f.spec = 'lemke', s.experiment = f.experiment AND s.paper_solver IN ('PATH', 'IP'),
               f.experiment LIKE 'exp6%' AND s.experiment = 'exp5' || substr(f.experiment, 5) AND s.spec = f.wrapped)),
-- `pairs` has no rows for solvers on two sets: their verdicts are compared here, problem by problem. NULL stands for a
-- problem that is proven to have no solution, which does not count. MATERIALIZED: each verdict is computed once.
met AS MATERIALIZED (
  SELECT named.*,
         CASE x.verdict WHEN 'solved' THEN 1 WHEN 'unsolvable' THEN NULL
           WHEN 'wrong' THEN iif(x.truth = 'unsolvable', NULL, 0) ELSE 0 END AS first_solved,
         CASE y.verdict WHEN 'solved' THEN 1 WHEN 'unsolvable' THEN NULL
           WHEN 'wrong' THEN iif(y.truth = 'unsolvable', NULL, 0) ELSE 0 END AS second_solved
  FROM named CROSS JOIN problems p CROSS JOIN problems q CROSS JOIN judged x CROSS JOIN judged y
  WHERE other_set <> named.set_id AND p.set_id = named.set_id AND q.set_id = other_set AND q.seed = p.seed
    AND q.trial = p.trial AND x.problem_id = p.id AND x.solver_id = named.solver_id AND y.problem_id = q.id
    AND y.solver_id = other_solver AND 'unsupported' NOT IN (x.claim, y.claim)),
counted AS (
  SELECT kind, experiment, redundancy, reading, other_readings, paper_solver, "set", solver, isa, build,
         second, second_isa, second_build, both_took - both_unsolvable AS problems, only_a, only_b
  FROM named JOIN pairs USING ("set", a, b) WHERE other_set = set_id
  -- `pairs` has each pair once, in the order of the names: "lemke" precedes the others, so it is always `a`.
  UNION ALL
  SELECT kind, experiment, redundancy, reading, other_readings, paper_solver, "set", solver, isa, build,
         second, second_isa, second_build, 1, first_solved AND NOT second_solved, second_solved AND NOT first_solved
  FROM met WHERE first_solved IS NOT NULL AND second_solved IS NOT NULL)
SELECT kind, experiment, redundancy, reading, other_readings, paper_solver, "set", solver, isa, second,
       SUM(problems) AS problems, SUM(only_a) AS only_first, SUM(only_b) AS only_second
FROM counted GROUP BY kind, experiment, reading, "set", solver, isa, build, second, second_isa, second_build
HAVING SUM(problems) > 0;
