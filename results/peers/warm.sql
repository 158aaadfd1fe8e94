-- Consecutive steps that each peer took, from nothing and from its own last answer
-- median_error: the velocity residual relative to the largest speed (rho); median_time_s: set-up and solve,
-- from outside; median_reported_s: the library's own call, as the program reports it.
SELECT replace(replace(s.name, 'file:build/peers/warm/', ''), '.scenes', '') AS scene,
       CASE WHEN v.name <> 'external' THEN v.name
            ELSE substr(v.settings, instr(v.settings, 'python/peers/') + 13,
                        instr(v.settings, ',form') - instr(v.settings, 'python/peers/') - 13) END AS solver,
       CASE WHEN v.settings LIKE '%start=last' THEN 'last' ELSE 'nothing' END AS start,
       COUNT(*) AS steps, SUM(j.verdict = 'solved') AS solved, SUM(j.verdict = 'wrong') AS wrong,
       quantile(x.velocity_residual_relative, 0.5) AS median_error, quantile(a.iterations, 0.5) AS median_iterations,
       quantile(t.setup_wall_s + t.solve_wall_s, 0.5) AS median_time_s,
       quantile(CASE WHEN a.detail LIKE 'reported: %' THEN CAST(substr(a.detail, 11) AS REAL) END, 0.5)
         AS median_reported_s
FROM judged j JOIN answers a USING (problem_id, solver_id, part) JOIN verdicts x USING (problem_id, solver_id, part)
JOIN timings t USING (problem_id, solver_id, part)
JOIN sets s ON s.id = j.set_id JOIN solvers v ON v.id = j.solver_id
WHERE a.claim <> 'unsupported'
GROUP BY 1, 2, 3 ORDER BY 1, 2, 3 DESC
