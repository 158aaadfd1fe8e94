-- Said solved, and was wrong
-- Solvers at single settings, over all sets. of: the problems that the solver took, refused ones left out. share: that
-- of false claims among these, with its 95 % interval. sets: those on which it was wrong.
SELECT label AS solver, SUM(false_claims) AS false_claims, SUM(trials - unsupported) AS of,
       1.0 * SUM(false_claims) / SUM(trials - unsupported) AS share,
       wilson_low(SUM(false_claims), SUM(trials - unsupported)) AS share_low,
       wilson_high(SUM(false_claims), SUM(trials - unsupported)) AS share_high,
       group_concat(iif(false_claims > 0, "set", NULL), ', ') AS sets
FROM cells WHERE sweep = '' GROUP BY label HAVING SUM(false_claims) > 0
ORDER BY share_low DESC, solver
