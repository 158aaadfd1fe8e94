-- Said solved, and was wrong
-- Solvers at single settings; the share is of the problems that the solver took. Refused problems are not among them.
SELECT label AS solver, "set", false_claims, trials - unsupported AS of,
       1.0 * false_claims / (trials - unsupported) AS share,
       wilson_low(false_claims, trials - unsupported) AS share_low,
       wilson_high(false_claims, trials - unsupported) AS share_high
FROM cells WHERE false_claims > 0 AND sweep = ''
ORDER BY share_low DESC, solver, "set"
