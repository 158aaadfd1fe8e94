-- Hard cases
-- What became of each case with each solver; truth is what the case's formula says of it, on which no verdict depends.
SELECT c."set", c.hard_truth AS truth, c.label AS solver, c.hard_outcome AS outcome, c."error.max" AS error,
       c."time.all.median" AS time_s
FROM cells c WHERE c.hard_outcome <> '' AND c.sweep = ''
