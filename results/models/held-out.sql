-- held-out.csv from the measured mixture.csv of those steps, imported as `mixture`, and the run's store, attached as `store`.
SELECT replace(substr(m."set", instr(m."set", 'many/') + 5), '.scenes', '') AS scene, count(*) AS steps,
  sum(m.rungs = '4') AS four_edges_suffice, sum(m.met = 1) AS within_1e_3,
  sum(v.velocity_residual_relative <= 1e-8) AS cone_1e_8,
  sum(v.velocity_residual_relative <= 1e-8 AND m.cone_s + 0 <= 5 * m.sixteen_s) AS cone_1e_8_in_5_times_16
FROM mixture m
JOIN store.sets s ON s.name = m."set"
JOIN store.problems p ON p.set_id = s.id AND p.trial = m.trial AND p.n > p.nc
JOIN store.verdicts v ON v.problem_id = p.id
JOIN store.solvers o ON o.id = v.solver_id AND o.name = 'cone_ipm'
GROUP BY 1;
