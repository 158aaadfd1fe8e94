-- Every set and solver
-- Solvers at single settings: share solved of the problems that the solver took and that are not proven unsolvable, with its 95 % interval, false claims, time, error, and the worst problem with the command that repeats it.
SELECT c."set", c.label AS solver, c.library, c.trials AS problems, 1.0 * a.solved / a."of" AS solved_share,
       wilson_low(a.solved, a."of") AS solved_share_low, wilson_high(a.solved, a."of") AS solved_share_high,
       1.0 * c.solved_1e9 / a."of" AS solved_1e9_share,
       c.false_claims, c.gave_up, c.unsupported AS refused,
       c."time.all.median" AS median_time_s, c."time.all.median_low" AS median_time_low_s,
       c."time.all.median_high" AS median_time_high_s,
       c.time_ratio, c.time_ratio_low, c.time_ratio_high, c.time_ratio_problems, c."error.median" AS error_median,
       c."error.p99" AS error_p99, c.reliability, c.model,
       c."solver_error_m_per_s.median" AS solver_error_median_m_per_s,
       c."model_error_m_per_s.median" AS model_error_median_m_per_s, w.trial AS worst_trial, w.command AS worst_replay
FROM cells c
     LEFT JOIN at_errors a ON a."set" = c."set" AND a.solver = c.label AND a.error IS NULL
     LEFT JOIN worst w ON w."set" = c."set" AND w.solver = c.label AND w.place = 1
WHERE c.sweep = ''
