-- Peers on captured steps: shares of the steps that each took, and how near its answers come
-- median_error: rho, see docs/explanation/verdicts.md. Times are geometric means:
-- mean_time_s of set-up and solve, from outside; mean_reported_s of the library's own call, as the program reports it.
SELECT CASE WHEN NOT p.free_bodies THEN 'A robot''s step' WHEN s.name GLOB 'scene/*-pile/*' THEN 'Piles'
            WHEN s.name GLOB 'scene/stack/*' OR s.name GLOB 'scene/wall/*' OR s.name GLOB 'scene/card-house/*'
            THEN 'Stacks and walls'
            ELSE 'Other scenes' END AS contacts,
       CASE WHEN v.name <> 'external' THEN v.name
            ELSE replace(substr(v.settings, instr(v.settings, 'python/peers/') + 13,
                                coalesce(nullif(instr(v.settings, ',form'), 0), length(v.settings) + 1)
                                - instr(v.settings, 'python/peers/') - 13), '"', '') END AS solver,
       SUM(a.claim <> 'unsupported') AS problems, SUM(j.verdict = 'solved') AS solved,
       wilson_low(SUM(j.verdict = 'solved'), SUM(a.claim <> 'unsupported')) AS "solved.low",
       wilson_high(SUM(j.verdict = 'solved'), SUM(a.claim <> 'unsupported')) AS "solved.high",
       SUM(j.verdict = 'wrong') AS false_claims, SUM(a.claim = 'unsupported') AS refused,
       exp(avg(CASE WHEN a.claim <> 'unsupported' THEN ln(t.setup_wall_s + t.solve_wall_s) END)) AS mean_time_s,
       exp(avg(CASE WHEN a.detail LIKE 'reported: %' THEN ln(CAST(substr(a.detail, 11) AS REAL)) END))
         AS mean_reported_s,
       quantile(CASE WHEN a.claim <> 'unsupported' THEN x.velocity_residual_relative END, 0.5) AS median_error,
       SUM(x.velocity_residual_relative < 1e-3) AS below_1e3, SUM(x.velocity_residual_relative < 1e-2) AS below_1e2
FROM judged j JOIN answers a USING (problem_id, solver_id, part) JOIN verdicts x USING (problem_id, solver_id, part)
JOIN timings t USING (problem_id, solver_id, part) JOIN problems p ON p.id = j.problem_id
JOIN sets s ON s.id = j.set_id JOIN solvers v ON v.id = j.solver_id
GROUP BY 1, 2 ORDER BY 1, 2
