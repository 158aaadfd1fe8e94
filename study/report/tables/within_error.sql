-- Share answered within an error
-- Answers of at most this error among the problems that the solver took and that are not proven unsolvable; an empty error is the verdict's own threshold.
-- only in tables/
SELECT "set", solver, error, solved, "of", 1.0 * solved / "of" AS share, wilson_low(solved, "of") AS share_low,
       wilson_high(solved, "of") AS share_high, wrong, taken, mean_time_s
FROM at_errors
