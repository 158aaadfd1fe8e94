-- What a limit costs: of the answers that libraries found on the frictional problems of the committed run of the plan
-- `paper` (10 s for each solve, the libraries' own limits), how many took longer or more steps.
-- sqlite3 -csv -header paper.db < results/adapters/limits.sql > results/adapters/limits.csv
SELECT v.name AS solver, count(*) AS problems, sum(x.solved) AS solved,
       sum(x.solved AND t.setup_cpu_s + t.solve_cpu_s > 0.1) AS "solved_after_0.1_s",
       sum(x.solved AND t.setup_cpu_s + t.solve_cpu_s > 1.1) AS "solved_after_1.1_s",
       sum(x.solved AND a.iterations > 200) AS solved_after_200_iterations,
       sum(x.solved AND a.pivots > 300) AS solved_after_300_pivots,
       round(avg(min(t.setup_wall_s + t.solve_wall_s, 10)), 4) AS mean_s
FROM solvers v
JOIN answers a ON a.solver_id = v.id
JOIN verdicts x USING (problem_id, solver_id, part)
JOIN timings t USING (problem_id, solver_id, part)
JOIN problems p ON p.id = a.problem_id
JOIN sets s ON s.id = p.set_id
WHERE v.sweep = '' AND v.settings = ''
  AND v.name IN ('bullet_lemke', 'bullet_mlcp_lemke', 'ipopt_mpcc', 'ipopt_scholtes', 'siconos_avi', 'siconos_lemke',
                 'siconos_newton_fb')
  AND s.name IN ('paper/copositive/exp1', 'paper/copositive/exp2{redundancy=combination}', 'paper/copositive/exp3',
                 'paper/copositive/exp4{redundancy=combination}', 'paper/copositive/exp5-1e5{redundancy=combination}',
                 'paper/copositive/exp5-1e8{redundancy=combination}', 'paper/copositive/exp5-1e10{redundancy=combination}')
GROUP BY 1;
