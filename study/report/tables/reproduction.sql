-- Published shares that the study reproduces
-- Ours less the published one, 20,000 trials behind it: reproduced where the 95 % interval of the difference comes within 1 point of 0; too few trials where its half-width exceeds 2 points. By its rules of 2012 a solver is counted as its authors counted it: any answer. docs/explanation/paper-study.md says what is known of the rows that differ.
WITH counterparts AS (
  SELECT r."set", r.paper_solver, r.solver, r.refused, p.worst AS published_worst, p.average AS published_average,
         p.best AS published_best, r."worst.share" AS worst, r."worst.of" AS worst_of, r."average.share" AS average,
         r."average.of" AS average_of, r."best.share" AS best, r."best.of" AS best_of
  FROM paper_rates r JOIN published p
    ON p.kind = r.kind AND p.experiment = r.experiment AND p.solver = r.paper_solver AND p.quantity = 'rate'
  WHERE r.other_readings = '' AND r.solved_by = iif(r.rules_2012, 'criterion_any', 'criterion')),
statistics AS (
  SELECT "set", paper_solver, solver, refused, 'worst' AS statistic, published_worst AS published, worst AS ours,
         worst_of AS "of" FROM counterparts
  UNION ALL SELECT "set", paper_solver, solver, refused, 'average', published_average, average, average_of
         FROM counterparts
  UNION ALL SELECT "set", paper_solver, solver, refused, 'best', published_best, best, best_of FROM counterparts),
compared AS (
  SELECT *, difference_low(ours, "of", published, 20000) AS low, difference_high(ours, "of", published, 20000) AS high
  FROM statistics WHERE published IS NOT NULL)
SELECT "set", paper_solver, solver, statistic, published, ours, low, high,
       CASE WHEN refused <> '' THEN 'refused' WHEN high IS NULL OR high - low > 0.04 THEN 'too few trials'
            WHEN low <= 0.01 AND high >= -0.01 THEN 'reproduced' ELSE 'differs' END AS result
FROM compared ORDER BY "set", solver, statistic DESC
