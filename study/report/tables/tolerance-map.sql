-- Share solved over the two tolerances of Lemke's algorithm
-- Each parameterisation on the paper's sets that has both tolerances.
-- only in tables/
SELECT c."set", c.name AS solver, c.sweep, c.pivot_tolerance, c.zero_tolerance, c.trials,
       1.0 * p.part / p."of" AS "criterion.share", wilson_low(p.part, p."of") AS "criterion.low",
       wilson_high(p.part, p."of") AS "criterion.high", p."of" AS "criterion.of",
       1.0 * v.part / v."of" AS "verdict.share", wilson_low(v.part, v."of") AS "verdict.low",
       wilson_high(v.part, v."of") AS "verdict.high", v."of" AS "verdict.of"
FROM paper_cells c JOIN paper_counts p USING (place) JOIN paper_counts v USING (place)
WHERE p.solved_by = 'criterion' AND v.solved_by = 'verdict' AND c.sweep <> '' AND c.refused < c.trials
  AND c.pivot_tolerance IS NOT NULL AND c.zero_tolerance IS NOT NULL
