-- What each reading of the paper changes
-- Sweeps on sets with options off their defaults, beside the same sweep at the defaults: differences of shares with 95 % intervals.
SELECT a."set", a.solver, a.solved_by,
       b."worst.share" AS worst_default, a."worst.share" AS worst_reading,
       a."worst.share" - b."worst.share" AS worst_difference,
       difference_low(a."worst.share", a."worst.of", b."worst.share", b."worst.of") AS worst_low,
       difference_high(a."worst.share", a."worst.of", b."worst.share", b."worst.of") AS worst_high,
       b."average.share" AS average_default, a."average.share" AS average_reading,
       a."average.share" - b."average.share" AS average_difference,
       difference_low(a."average.share", a."average.of", b."average.share", b."average.of") AS average_low,
       difference_high(a."average.share", a."average.of", b."average.share", b."average.of") AS average_high,
       b."best.share" AS best_default, a."best.share" AS best_reading,
       a."best.share" - b."best.share" AS best_difference,
       difference_low(a."best.share", a."best.of", b."best.share", b."best.of") AS best_low,
       difference_high(a."best.share", a."best.of", b."best.share", b."best.of") AS best_high,
       b."held_out.share" AS held_out_default, a."held_out.share" AS held_out_reading,
       a."held_out.share" - b."held_out.share" AS held_out_difference,
       difference_low(a."held_out.share", a."held_out.of", b."held_out.share", b."held_out.of") AS held_out_low,
       difference_high(a."held_out.share", a."held_out.of", b."held_out.share", b."held_out.of") AS held_out_high
FROM paper_rates a JOIN paper_rates b
  ON b.kind = a.kind AND b.experiment = a.experiment AND b.solver = a.solver AND b.solved_by = a.solved_by
     AND b.other_readings = '' AND b.redundancy IN ('', 'multiple') AND b."set" NOT LIKE '%{%'
WHERE a."set" LIKE '%{%' AND a.refused = '' AND b.refused = ''
