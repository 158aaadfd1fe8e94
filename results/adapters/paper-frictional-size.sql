-- Shares solved of the frictional problems of at most 130 rows, and of the others.
-- sqlite3 -csv -header paper-frictional.db < results/adapters/paper-frictional-size.sql > results/adapters/paper-frictional-size.csv
SELECT v.name AS solver, substr(s.name, 18) AS "set", sum(p.n <= 130) AS small,
       round(100.0 * sum(p.n <= 130 AND x.solved) / sum(p.n <= 130), 1) AS small_solved,
       round(100.0 * sum(p.n <= 130 AND x.natural_residual <= 1e-6) / sum(p.n <= 130), 1) AS "small_natural_1e-6",
       sum(p.n > 130) AS large, round(100.0 * sum(p.n > 130 AND x.solved) / sum(p.n > 130), 1) AS large_solved,
       sum(p.n <= 130 AND a.claim = 'time_limit') AS small_time_limit, sum(p.n > 130 AND a.claim = 'time_limit') AS large_time_limit
FROM solvers v
JOIN answers a ON a.solver_id = v.id
JOIN verdicts x USING (problem_id, solver_id, part)
JOIN problems p ON p.id = a.problem_id
JOIN sets s ON s.id = p.set_id
GROUP BY 1, 2;
