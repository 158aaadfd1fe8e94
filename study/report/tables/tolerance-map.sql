-- Share solved over the two tolerances of Lemke's algorithm
-- Each parameterisation on the paper's sets that has both tolerances.
-- only in tables/
SELECT "set", name AS solver, sweep, pivot_tolerance, zero_tolerance, trials, "criterion.share", "criterion.low", "criterion.high",
       "criterion.of", "verdict.share", "verdict.low", "verdict.high", "verdict.of"
FROM paper_cells WHERE sweep <> '' AND pivot_tolerance IS NOT NULL AND zero_tolerance IS NOT NULL
