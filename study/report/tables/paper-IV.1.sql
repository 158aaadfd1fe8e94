-- Table IV.1 of the paper: share solved, monotone problems
-- Worst, average and best over each solver's parameterisations, published beside measured. Solved by the paper's criterion: normal violation below 1e-3 m/s and work gain below 1e-3 J, of all trials, of answers that the solver claims (criterion) or of any answer (criterion_any); by the verdict: every condition holds to 1e-4 relative, of the trials not proven unsolvable. held_out: the best parameterisation of the even trials, on the odd ones. No solver: the store has no such sweep.
SELECT p.title AS experiment, r.redundancy, p.solver AS paper_solver, r.solver, r.solved_by,
       p.worst AS published_worst, p.average AS published_average, p.best AS published_best,
       r."worst.share" AS worst, r."average.share" AS average, r."best.share" AS best,
       r."best.low" AS best_low, r."best.high" AS best_high, r."held_out.share" AS held_out, r.sigma,
       r.parameterisations, r."average.of" AS trials, r.best_settings, r.refused
FROM published p LEFT JOIN paper_rates r
  ON r.kind = p.kind AND r.experiment = p.experiment AND r.paper_solver = p.solver AND r.other_readings = ''
WHERE p."table" = 'IV.1' AND p.quantity = 'rate' AND EXISTS (SELECT 1 FROM paper_rates)
UNION ALL
SELECT r.experiment, r.redundancy, NULL, r.solver, r.solved_by, NULL, NULL, NULL, r."worst.share", r."average.share",
       r."best.share", r."best.low", r."best.high", r."held_out.share", r.sigma, r.parameterisations, r."average.of",
       r.best_settings, r.refused
FROM paper_rates r WHERE r.kind = 'monotone' AND r.paper_solver IS NULL AND r.other_readings = ''
