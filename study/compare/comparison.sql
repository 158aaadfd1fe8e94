-- The cells of `compare --format json`: names with dots are members of members. `solver` is "lemke [1.0 -> 2.0]", or
-- "lemke [1.0] [avx2]" where a set has several rows of one name.
-- Rows without a set: each single solver over all sets, where there are several.
CREATE TABLE compared AS
WITH every AS (
  SELECT * FROM changes
  UNION ALL
  SELECT NULL, a, b, SUM(problems), SUM(other_data), SUM(only_in_a), SUM(only_in_b), SUM(solved_a), SUM(solved_b),
         SUM(lost), SUM(gained), SUM(false_a), SUM(false_b), SUM(false_gone), SUM(false_new), SUM(timed), SUM(logs),
         SUM(log_squares), SUM(faster), SUM(slower), NULL, SUM(counted), SUM(pivots_a), SUM(pivots_b)
  FROM changes JOIN cells ON cells.rowid = a
  WHERE sweep = '' AND (SELECT COUNT(DISTINCT "set") FROM changes) > 1 GROUP BY a, b),
tested AS (
  SELECT every.*, ROW_NUMBER() OVER () AS place, sweep <> '' AS swept, "set" IS NULL AS pooled,
         mcnemar(lost, gained) AS p, mcnemar(false_gone, false_new) AS false_p, mcnemar(faster, slower) AS time_p,
         iif(timed, exp(logs / timed), NULL) AS ratio, log_mean_low(timed, logs, log_squares) AS low,
         log_mean_high(timed, logs, log_squares) AS high
  FROM every JOIN cells ON cells.rowid = a),
-- Holm's correction: of the cells, of the solvers over all sets, and of the cells of sweeps, each a family.
steps AS (
  SELECT *, MIN(1, (COUNT(*) OVER family + 1 - ROW_NUMBER() OVER (family ORDER BY p, place)) * p) AS step,
         MIN(1, (COUNT(*) OVER family + 1 - ROW_NUMBER() OVER (family ORDER BY false_p, place)) * false_p)
           AS false_step,
         MIN(1, (COUNT(*) OVER family + 1 - ROW_NUMBER() OVER (family ORDER BY time_p, place)) * time_p) AS time_step,
         COUNT(*) OVER family * mcnemar(problems, 0) >= 0.05 AS too_few
  FROM tested WINDOW family AS (PARTITION BY swept, pooled)),
corrected AS (
  SELECT *, MAX(step) OVER (family ORDER BY p, place) AS p_holm,
         MAX(false_step) OVER (family ORDER BY false_p, place) AS false_p_holm,
         MAX(time_step) OVER (family ORDER BY time_p, place) AS time_p_holm
  FROM steps WINDOW family AS (PARTITION BY swept, pooled)),
tendencies AS (
  SELECT *, iif(p_holm >= 0.05, 'tie', iif(gained > lost, 'better', 'worse')) AS solved_is,
         iif(false_p_holm >= 0.05, 'tie', iif(false_gone > false_new, 'better', 'worse')) AS false_is,
         CASE WHEN swept OR low IS NULL OR high IS NULL THEN 'unknown'
              WHEN (ratio < 1.05 AND ratio > 1 / 1.05) OR (low <= 1 AND high >= 1) OR time_p_holm >= 0.05 THEN 'tie'
              ELSE iif(ratio < 1, 'better', 'worse') END AS time_is
  FROM corrected),
worded AS (
  SELECT *, iif(solved_is = 'better', ', solves more', '') || iif(solved_is = 'worse', ', solves fewer', '') ||
         iif(false_new > 0, printf(', %d new false claim%s', false_new, iif(false_new > 1, 's', '')), '') ||
         iif(false_is = 'better', ', fewer false claims', '') || iif(time_is = 'better', ', faster', '') ||
         iif(time_is = 'worse', ', slower', '') AS words
  FROM tendencies)
SELECT "set", a.solver AS "a.solver", a.settings AS "a.settings", a.library AS "a.library", a.version AS "a.version",
       a.isa AS "a.isa", a.sweep AS "a.sweep", b.solver AS "b.solver", b.settings AS "b.settings",
       b.library AS "b.library", b.version AS "b.version", b.isa AS "b.isa", b.sweep AS "b.sweep", problems,
       other_data AS "left_out.other_data", only_in_a AS "left_out.only_in_a", only_in_b AS "left_out.only_in_b",
       solved_a AS "solved.a", solved_b AS "solved.b", lost AS "solved.only_a", gained AS "solved.only_b",
       p AS "solved.p", p_holm AS "solved.p_holm", solved_is AS "solved.b_is", too_few AS "solved.too_few",
       false_a AS "false_claims.a", false_b AS "false_claims.b", false_gone AS "false_claims.only_a",
       false_new AS "false_claims.only_b", false_p AS "false_claims.p", false_p_holm AS "false_claims.p_holm",
       false_is AS "false_claims.b_is", timed AS "time.problems", ratio AS "time.ratio",
       iif(swept, NULL, low) AS "time.low", iif(swept, NULL, high) AS "time.high", median_ratio AS "time.median_ratio",
       faster AS "time.faster", slower AS "time.slower", time_p_holm AS "time.p_holm", time_is AS "time.b_is",
       counted AS "pivots.problems", pivots_a AS "pivots.a", pivots_b AS "pivots.b",
       solved_is = 'worse' OR false_new > 0 AS regressed, iif(words = '', 'tie', substr(words, 3)) AS change,
       CASE WHEN false_new > 0 THEN 0 WHEN solved_is = 'worse' THEN 1 WHEN time_is = 'worse' THEN 2
            ELSE iif(words = '', 4, 3) END AS gravity,
       a.name || iif(a.name = b.name, '', ' -> ' || b.name) ||
         CASE WHEN a.library <> b.library THEN ''
              WHEN a.version <> b.version THEN ' [' || a.version || ' -> ' || b.version || ']'
              WHEN COUNT(*) OVER alike > 1 THEN ' [' || a.version || ']' ELSE '' END ||
         CASE WHEN '' IN (a.isa, b.isa) THEN '' WHEN a.isa <> b.isa THEN ' [' || a.isa || ' -> ' || b.isa || ']'
              WHEN COUNT(*) OVER alike > 1 THEN ' [' || a.isa || ']' ELSE '' END AS solver
FROM worded JOIN cells a ON a.rowid = worded.a JOIN cells b ON b.rowid = worded.b
WINDOW alike AS (PARTITION BY "set", a.name, b.name) ORDER BY place;
-- `solved.too_few`: not even the loss of every problem would be significant.
CREATE VIEW conclusion AS
SELECT TOTAL(problems) > 0 AS met, MAX(regressed) AS regressed, MAX("time.b_is" = 'worse') AS slower,
       iif(SUM("set" IS NULL),
           printf('Solvers over all sets: %,d. Solved: %d better, %d worse. Time: %d faster, %d slower. ',
           SUM("set" IS NULL), SUM("set" IS NULL AND "solved.b_is" = 'better'),
           SUM("set" IS NULL AND "solved.b_is" = 'worse'), SUM("set" IS NULL AND "time.b_is" = 'better'),
           SUM("set" IS NULL AND "time.b_is" = 'worse')), '') || summary AS summary,
       CASE WHEN MAX(regressed) THEN 'B is worse.'
            WHEN MAX("time.b_is" = 'worse') THEN 'B is no less reliable, but slower.'
            WHEN MIN(change = 'tie' AND "solved.too_few")
            THEN 'No difference beyond noise, and too few problems to tell.'
            WHEN MIN(change = 'tie') THEN 'B is a tie with A: no difference beyond noise.'
            ELSE 'B is better, and nowhere less reliable or slower.' END ||
         coalesce((SELECT ' ' || group_concat(text, '; ') || '.'
                   FROM (SELECT solver || iif("set" IS NULL, '', ' on ' || "set") || ': ' || change ||
                                iif("solved.b_is" = 'tie', '', printf(' (%,d → %,d of %,d)', "solved.a", "solved.b",
                                problems)) ||
                                iif("time.b_is" IN ('better', 'worse'), printf(' (%.3g times)', "time.ratio"), '')
                         AS text FROM compared WHERE change <> 'tie' ORDER BY "set" IS NOT NULL, gravity LIMIT 3)), '')
         AS conclusion FROM compared,
     (SELECT printf('Cells, each alone: %,d. Solved: %d better, %d worse. Cells with new false claims: %d. ' ||
                    'Time: %d faster, %d slower.', COUNT(*), SUM("solved.b_is" = 'better'),
                    SUM("solved.b_is" = 'worse'), SUM(gravity = 0), SUM("time.b_is" = 'better'),
                    SUM("time.b_is" = 'worse')) ||
             iif(SUM("solved.too_few"), printf(' %,d cells have too few problems for a test of their own.',
                                               SUM("solved.too_few")), '') ||
             iif(SUM("left_out.other_data"),
                 printf(' Left out: %,d answers to problems whose data differ between the stores.',
                        SUM("left_out.other_data")), '') ||
             iif(SUM("left_out.only_in_a" + "left_out.only_in_b"),
                 printf(' Left out: %,d answers that only one store has.',
                        SUM("left_out.only_in_a" + "left_out.only_in_b")), '') AS summary
      FROM compared WHERE "set" IS NOT NULL);
