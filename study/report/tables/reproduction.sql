-- Published shares that the study reproduces
-- Ours less the published one, 20,000 trials behind it: reproduced where the 95 % interval of the difference comes within 1 point of 0; too few trials where its half-width exceeds 2 points. docs/explanation/paper-study.md says what is known of the rows that differ.
WITH published_shares AS (
  SELECT r."set", r.paper_solver, r.solver, statistic, r.refused, share AS ours, "of",
         CASE statistic WHEN 'worst' THEN p.worst WHEN 'average' THEN p.average WHEN 'best' THEN p.best END AS published
  FROM paper_statistics r JOIN published p
    ON p.kind = r.kind AND p.experiment = r.experiment AND p.solver = r.paper_solver AND p.quantity = 'rate'
  WHERE r.other_readings = '' AND r.solved_by = 'criterion'),
compared AS (
  SELECT *, difference_low(ours, "of", published, 20000) AS low, difference_high(ours, "of", published, 20000) AS high
  FROM published_shares WHERE published IS NOT NULL)
SELECT "set", paper_solver, solver, statistic, published, ours, low, high,
       CASE WHEN refused <> '' THEN 'refused' WHEN high IS NULL OR high - low > 0.04 THEN 'too few trials'
            WHEN low <= 0.01 AND high >= -0.01 THEN 'reproduced' ELSE 'differs' END AS result
FROM compared ORDER BY "set", solver, statistic DESC
