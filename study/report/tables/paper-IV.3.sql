-- Table IV.3 of the paper: running time of Experiment 6, monotone problems [s]
-- Mean, standard deviation and maximum at the best parameterisation (chosen on the even trials, measured on the odd ones) and over all of them, published beside measured. Seconds of 2012 and of this machine are not compared; ratios between solvers are.
SELECT p.title AS experiment, m.redundancy, p.quantity, p.solver AS paper_solver, m.solver, m.solved_by,
       p.best_mean AS published_best_mean, p.best_sigma AS published_best_sigma, p.best_max AS published_best_max,
       m."best.mean" AS best_mean, m."best.sigma" AS best_sigma, m."best.max" AS best_max,
       p.all_mean AS published_all_mean, p.all_sigma AS published_all_sigma, p.all_max AS published_all_max,
       m."all.mean" AS all_mean, m."all.sigma" AS all_sigma, m."all.max" AS all_max, m."all.n" AS n, m.best_settings
FROM published p LEFT JOIN paper_measurements m
  ON m.kind = p.kind AND m.experiment = p.experiment AND m.paper_solver = p.solver AND m.quantity = p.quantity
     AND m.other_readings = ''
WHERE p."table" = 'IV.3' AND EXISTS (SELECT 1 FROM paper_rates)
