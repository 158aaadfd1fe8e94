-- Solvers in pairs on the same problems
-- Exact McNemar test of the problems that one of the two solved alone, corrected over all pairs of the set by Holm's method. The factor is the time of b over that of a, a geometric mean over the problems that both solved.
-- only in tables/
WITH tested AS (SELECT *, mcnemar(only_a, only_b) AS p FROM pairs),
     ranked AS (SELECT *, MIN(1, (COUNT(*) OVER (PARTITION BY "set") + 1 - ROW_NUMBER() OVER (
                  PARTITION BY "set" ORDER BY p, a, b)) * p) AS step FROM tested)
SELECT "set", a, b, both_took, only_a, only_b, p, MAX(step) OVER (PARTITION BY "set" ORDER BY p, a, b) AS p_holm,
       false_only_a, false_only_b, timed, time_factor, time_factor_low, time_factor_high
FROM ranked ORDER BY "set", a, b
