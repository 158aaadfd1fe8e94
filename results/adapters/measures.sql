-- Shares solved by other measures: rho is the verdict's, natural is max|min(z_i, w_i)|, which mixes units.
-- sqlite3 -csv -header paper.db < results/adapters/measures.sql > results/adapters/measures.csv
SELECT v.name AS solver, substr(s.name, 16) AS "set", count(*) AS problems,
       round(100.0 * sum(x.solved) / count(*), 1) AS "rho_1e-4",
       round(100.0 * sum(coalesce(x.velocity_residual_relative, 9) <= 1e-6) / count(*), 1) AS "rho_1e-6",
       round(100.0 * sum(coalesce(x.natural_residual, 9) <= 1e-6) / count(*), 1) AS "natural_1e-6",
       round(100.0 * sum(coalesce(x.natural_residual, 9) <= 1e-5) / count(*), 1) AS "natural_1e-5",
       round(100.0 * sum(j.claim = 'time_limit') / count(*), 1) AS time_limit
FROM solvers v
JOIN judged j ON j.solver_id = v.id
JOIN verdicts x ON x.problem_id = j.problem_id AND x.solver_id = v.id AND x.part = j.part
JOIN problems p ON p.id = j.problem_id
JOIN sets s ON s.id = p.set_id
WHERE v.sweep = '' AND v.settings = ''
  AND v.name IN ('siconos_lemke', 'ipopt_qp', 'bullet_dantzig', 'ode_dantzig', 'bullet_lemke')
  AND s.name IN ('paper/monotone/exp1', 'paper/monotone/exp2{redundancy=combination}', 'paper/monotone/exp3',
                 'paper/monotone/exp4{redundancy=combination}', 'paper/monotone/exp5-1e5{redundancy=combination}',
                 'paper/monotone/exp5-1e8{redundancy=combination}', 'paper/monotone/exp5-1e10{redundancy=combination}')
GROUP BY 1, 2;
