-- Consecutive steps, each solver from nothing and from its last answer
-- error: rho, see docs/explanation/verdicts.md; time: of set-up and solve, processor time.
SELECT replace(replace(s.name, 'file:', ''), '.scenes', '') AS scene,
       v.name || CASE replace(replace(v.settings, ',start=last', ''), 'start=last', '') WHEN '' THEN ''
                 ELSE '{' || replace(replace(v.settings, ',start=last', ''), 'start=last', '') || '}' END AS solver,
       CASE WHEN v.settings LIKE '%start=last' THEN 'last' ELSE 'nothing' END AS start,
       COUNT(*) AS steps, SUM(a.claim = 'unsupported') AS refused, SUM(j.verdict = 'solved') AS solved,
       SUM(j.verdict = 'wrong') AS wrong, quantile(x.velocity_residual_relative, 0.5) AS median_error,
       quantile(x.velocity_residual_relative, 0.9) AS error_90,
       quantile(t.setup_cpu_s + t.solve_cpu_s, 0.5) AS median_time_s
FROM judged j JOIN answers a USING (problem_id, solver_id, part) JOIN verdicts x USING (problem_id, solver_id, part)
JOIN timings t USING (problem_id, solver_id, part)
JOIN sets s ON s.id = j.set_id JOIN solvers v ON v.id = j.solver_id
GROUP BY 1, 2, 3 ORDER BY 1, 2, 3 DESC
