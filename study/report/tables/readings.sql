-- What each reading of the paper changes
-- Sweeps on sets with options off their defaults, each less the same sweep at the defaults: differences of shares with 95 % intervals, as if the trials were independent. Options that are no reading of the paper, such as condition, count too.
SELECT a."set", a.solver, a.solved_by, a.statistic, b.share AS share_default, a.share AS share_reading,
       a.share - b.share AS difference, difference_low(a.share, a."of", b.share, b."of") AS difference_low,
       difference_high(a.share, a."of", b.share, b."of") AS difference_high
FROM paper_statistics a JOIN paper_statistics b USING (kind, experiment, solver, solved_by, statistic)
WHERE b."set" NOT LIKE '%{%' AND a."set" LIKE '%{%' AND a.refused = '' AND b.refused = ''
