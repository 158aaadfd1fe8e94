-- Regret of auto
-- Time of auto over that of the fastest solver that said solved with at most this error, problem by problem: geometric mean with its 95 % interval, 99th percentile, largest, and how many are above 3 (large). auto is the one with the largest stated error up to the target. Its rivals solve the problem's own friction model, native ones of the same version at the same instruction-set level. missed: problems that some solver answered within the error and auto did not.
SELECT * FROM regret
