-- Along the condition number of the inertia
-- Sets that differ in the condition number alone.
SELECT f.family, f.dial AS condition, c.label AS solver, a.taken, 1.0 * a.solved / a."of" AS solved_share,
       wilson_low(a.solved, a."of") AS solved_share_low, wilson_high(a.solved, a."of") AS solved_share_high,
       c.false_claims, c."error.median" AS error_median, c."error.p99" AS error_p99,
       c."time.all.median" AS median_time_s, c.time_ratio
FROM set_facts f JOIN cells c ON c."set" = f.name
     JOIN at_errors a ON a."set" = c."set" AND a.solver = c.label AND a.error IS NULL
WHERE f.dial IS NOT NULL AND c.sweep = '' AND (SELECT COUNT(*) FROM set_facts g WHERE g.family = f.family) > 1
ORDER BY f.family, f.dial, c.label
