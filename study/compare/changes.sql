-- Adds what changed on the set at hand: answers to problems with the same data in pairs.
INSERT INTO changes
WITH met AS (
  SELECT m.place, m.a, m.b, y.problem, x.hash = y.hash AS same, x.solved AS solved_a, y.solved AS solved_b,
         x.wrong AS wrong_a, y.wrong AS wrong_b, x.pivots AS pivots_a, y.pivots AS pivots_b,
         x.hash = y.hash AND x.pivots >= 0 AND y.pivots >= 0 AS counted, x.time_s AS time_a, y.time_s AS time_b,
         x.hash = y.hash AND x.solved AND y.solved AND x.time_s > 0 AND y.time_s > 0 AS timed
  FROM (SELECT rowid AS place, * FROM matched WHERE EXISTS (SELECT 1 FROM answers WHERE cell = b)) m
  JOIN answers x ON x.cell = m.a LEFT JOIN answers y ON y.cell = m.b AND y.problem = x.problem)
SELECT (SELECT name FROM here), a, b, COUNT(*) FILTER (WHERE same), COUNT(*) FILTER (WHERE NOT same),
       COUNT(*) - COUNT(problem), (SELECT COUNT(*) FROM answers WHERE cell = b) - COUNT(problem),
       COUNT(*) FILTER (WHERE same AND solved_a), COUNT(*) FILTER (WHERE same AND solved_b),
       COUNT(*) FILTER (WHERE same AND solved_a AND NOT solved_b),
       COUNT(*) FILTER (WHERE same AND solved_b AND NOT solved_a),
       COUNT(*) FILTER (WHERE same AND wrong_a), COUNT(*) FILTER (WHERE same AND wrong_b),
       COUNT(*) FILTER (WHERE same AND wrong_a AND NOT wrong_b),
       COUNT(*) FILTER (WHERE same AND wrong_b AND NOT wrong_a),
       COUNT(*) FILTER (WHERE timed), TOTAL(ln(time_b / time_a)) FILTER (WHERE timed),
       TOTAL(ln(time_b / time_a) * ln(time_b / time_a)) FILTER (WHERE timed),
       COUNT(*) FILTER (WHERE timed AND time_b < time_a), COUNT(*) FILTER (WHERE timed AND time_b > time_a),
       median(iif(timed, time_b, NULL)) / median(iif(timed, time_a, NULL)), COUNT(*) FILTER (WHERE counted),
       coalesce(SUM(pivots_a) FILTER (WHERE counted), 0), coalesce(SUM(pivots_b) FILTER (WHERE counted), 0)
FROM met GROUP BY place;
INSERT INTO unmet
SELECT side, (SELECT name FROM here), c.rowid FROM cells c
WHERE EXISTS (SELECT 1 FROM answers WHERE cell = c.rowid) AND NOT EXISTS (
  SELECT 1 FROM matched WHERE (a = c.rowid AND EXISTS (SELECT 1 FROM answers WHERE cell = b))
                           OR (b = c.rowid AND EXISTS (SELECT 1 FROM answers WHERE cell = a)));
DELETE FROM answers;
