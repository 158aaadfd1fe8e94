-- Regret of auto
-- Time of auto over that of the fastest solver that said solved with at most this error, problem by problem: geometric mean with its 95 % interval, 99th percentile, largest, and the share above 3. auto is the one with the largest stated error up to the target. Its rivals solve the problem's own friction model, native ones at the same instruction-set level. missed: problems that some solver answered within the error and auto did not.
WITH targets(target) AS (VALUES (1e-2), (1e-4), (1e-6), (1e-9)),
autos AS (
  SELECT target, id, isa, ROW_NUMBER() OVER (
           PARTITION BY target ORDER BY iif(settings = '', 0, CAST(substr(settings, 7) AS REAL)) DESC, id) AS place
  FROM targets JOIN solvers
    ON name = 'auto' AND sweep = '' AND (settings = '' OR (settings LIKE 'error=%' AND instr(settings, ',') = 0))
  WHERE iif(settings = '', 0, CAST(substr(settings, 7) AS REAL)) <= target),
reached AS (
  SELECT c.target, a.problem_id, a.solver_id = c.id AS is_auto, t.setup_cpu_s + t.solve_cpu_s AS time_s
  FROM autos c CROSS JOIN problems p
  CROSS JOIN answers own ON own.problem_id = p.id AND own.solver_id = c.id
  CROSS JOIN answers a ON a.problem_id = p.id AND a.claim = 'solved'
  JOIN solvers s ON s.id = a.solver_id AND s.sweep = '' AND (s.isa = '' OR s.isa = c.isa)
  JOIN parameterisations m ON m.solver_id = s.id AND m.cell = 0 AND (m.friction = 'pyramid' OR p.n = p.nc)
  JOIN verdicts v ON v.problem_id = a.problem_id AND v.solver_id = a.solver_id AND v.part = a.part
  JOIN timings t ON t.problem_id = a.problem_id AND t.solver_id = a.solver_id AND t.part = a.part
  WHERE c.place = 1 AND IFNULL(v.velocity_residual_relative, v.backward_row_norm) <= c.target
    AND p.id NOT IN (SELECT problem_id FROM unsolvable)),
regrets AS (
  SELECT target, problem_id, MIN(time_s) AS fastest_s, MIN(iif(is_auto, time_s, NULL)) AS auto_s
  FROM reached GROUP BY target, problem_id)
SELECT target, COUNT(*) AS problems, geometric_mean(auto_s / fastest_s) AS mean,
       geometric_mean_low(auto_s / fastest_s) AS mean_low, geometric_mean_high(auto_s / fastest_s) AS mean_high,
       quantile(auto_s / fastest_s, 0.99) AS p99, MAX(auto_s / fastest_s) AS max, SUM(auto_s > 3 * fastest_s) AS large,
       SUM(auto_s IS NULL) AS missed
FROM regrets GROUP BY target
