-- Views over the temporary tables that one scan of the answers filled: see study/report/report.h.
CREATE TEMP VIEW decision AS SELECT * FROM contenders WHERE error IS NULL;
CREATE TEMP VIEW at_errors AS
SELECT s.name AS "set", v.label AS solver, e.error, json_extract(c.solved, '$[' || (e.rowid - 1) || ']') AS solved,
       json_extract(c.false, '$[' || (e.rowid - 1) || ']') AS wrong, c.met - c.refused - c.unsolvable AS "of",
       c.met - c.refused AS taken, exp(c.time_log_sum / c.time_n) AS mean_time_s
FROM cell_statistics c JOIN set_facts s ON s.rowid = c."set" + 1 JOIN solver_facts v ON v.rowid = c.solver + 1
     JOIN errors e
WHERE c.met > c.refused;
CREATE TEMP VIEW pairs AS
SELECT s.name AS "set", a.label AS a, b.label AS b, both_took, both_unsolvable, only_a, only_b,
       false_a AS false_only_a, false_b AS false_only_b, n AS timed, iif(n < least_problems, NULL, exp(log_sum / n))
       AS time_factor, iif(n < least_problems, NULL, log_mean_low(n, log_sum, log_square_sum)) AS time_factor_low,
       iif(n < least_problems, NULL, log_mean_high(n, log_sum, log_square_sum)) AS time_factor_high
FROM pair_statistics p JOIN set_facts s ON s.rowid = p."set" + 1 JOIN solver_facts a ON a.rowid = p.a + 1
     JOIN solver_facts b ON b.rowid = p.b + 1 JOIN rule
WHERE error = 0;
CREATE TEMP VIEW regret AS
SELECT target, COUNT(*) AS problems, exp(AVG(log)) AS mean, log_mean_low(COUNT(log), SUM(log),
       SUM(log * log)) AS mean_low, log_mean_high(COUNT(log), SUM(log), SUM(log * log)) AS mean_high,
       quantile(ratio, 0.99) AS p99, MAX(ratio) AS max, SUM(coalesce(ratio > 3, 0)) AS large,
       COUNT(*) - COUNT(ratio) AS missed
FROM (SELECT *, ln(ratio) AS log FROM regrets) GROUP BY target;
-- What became of each case of hard/ with each solver.
CREATE TEMP VIEW hard_cases AS
SELECT c."set", f.truth, c.label AS solver, CASE
         WHEN k.claim = 'unsupported' OR k.refused > 0 THEN 'refused'
         WHEN k.wrong > 0 THEN 'false_claim'
         WHEN k.solved > 0 THEN iif(k.claim = 'solved', 'solved', 'solved_unclaimed')
         WHEN k.unsolvable > 0 THEN iif(k.claim = 'unsolvable', 'rightly_unsolvable', 'gave_up_unsolvable')
         WHEN k.missed > 0 THEN iif(k.claim = 'unsolvable', 'wrongly_unsolvable', 'missed')
         ELSE 'undecided' END AS outcome, c."error.max" AS error, c."time.all.median" AS time_s
FROM cells c JOIN set_facts f ON f.name = c."set" AND f.hard
     JOIN claims k ON k."set" = c."set" AND k.label = c.label
                      AND k.solved + k.wrong + k.unsolvable + k.refused + k.missed + k.open > 0
WHERE c.sweep = '';

-- For each kind of contacts whom to show: the solver to use, or the one that leads; with more detail the best of Bullet
-- and of ODE by the share that is sure to be solved of all problems met, then reliable solvers that are more accurate than every faster one. Before all
-- these stand the solvers that the user named, in that order.
CREATE TEMP VIEW terminal_answer AS
WITH ranked AS (
  SELECT *, contenders.rowid AS place, ROW_NUMBER() OVER (
           PARTITION BY contacts ORDER BY recommended DESC, reliability = 'false_claims',
                                          wilson_low("solved.part", "solved.whole" + "refused.part") DESC) = 1
           AND "solved.whole" > 0 AS leads,
         CASE WHEN solver LIKE 'bullet@_%' ESCAPE '@' THEN 'Bullet' WHEN solver LIKE 'ode@_%' ESCAPE '@' THEN 'ODE' END
           AS engine,
         MAX(recommended) OVER (PARTITION BY contacts) AND coalesce(reliable, 0) AND "refused.part" = 0 AS usable
  FROM contenders WHERE error IS NULL),
finer AS (
  SELECT place, ROW_NUMBER() OVER (PARTITION BY contacts ORDER BY "mean_time_s.value") AS number
  FROM (SELECT *, MIN(error_p99) OVER (PARTITION BY contacts ORDER BY "mean_time_s.value"
                                       ROWS BETWEEN UNBOUNDED PRECEDING AND 1 PRECEDING) AS least
        FROM ranked WHERE usable) WHERE error_p99 < least),
parts AS (
  SELECT ranked.*, CASE WHEN leads THEN iif(recommended, 'use', '(leads)') WHEN number IS NOT NULL THEN 'accurate'
           ELSE coalesce(engine, iif(named.rowid IS NOT NULL, '', NULL)) END AS part, named.rowid AS named,
         CASE WHEN leads OR named.rowid IS NOT NULL THEN 0 WHEN number IS NOT NULL THEN number + 1 ELSE 1 END AS detail,
         ROW_NUMBER() OVER (PARTITION BY contacts, engine, number IS NULL AND NOT leads
                            ORDER BY wilson_low("solved.part", "solved.whole" + "refused.part") DESC,
                                     ranked.place) AS of_engine
  FROM ranked LEFT JOIN finer USING (place) LEFT JOIN named ON named.solver = ranked.solver)
SELECT detail, iif(ROW_NUMBER() OVER (PARTITION BY contacts ORDER BY named IS NULL, named, NOT leads) = 1, contacts, '')
         AS contacts, part,
       solver || iif("refused.part" > 0, printf(' (refused %d of %d)', "refused.part", "refused.whole"), '') AS solver,
       percent("solved.share") AS solved, percent_range("solved.low", "solved.high") AS range,
       percent("false_claims.share") AS wrong, duration("mean_time_s.value") AS time,
       CASE WHEN leads THEN '1' WHEN "factor.problems" = 0 THEN NULL
            WHEN "factor.problems" < least_problems THEN printf('- (n=%d)', "factor.problems")
            ELSE factor("factor.value") || 'x (' || factor("factor.low") || '–' || factor("factor.high") || ') n=' ||
                 "factor.problems" END AS factor,
       scientific(error_p99) AS error
FROM parts JOIN rule WHERE part IS NOT NULL AND (part NOT IN ('Bullet', 'ODE') OR of_engine = 1 OR named)
ORDER BY (SELECT MIN(rowid) FROM contenders c WHERE c.contacts = parts.contacts), named IS NULL, named,
         part NOT IN ('use', '(leads)'),
         part <> 'accurate', "mean_time_s.value";
-- A line of a set's heading, then its solvers; what has no numbers is a line of words.
CREATE TEMP VIEW terminal_results AS
WITH rows AS (
  SELECT "set", cells.rowid AS place, label || iif(trials < (SELECT problems FROM set_facts WHERE name = "set"),
           ' n=' || trials, '') AS solver,
         percent(rate) || iif("error.measure" = 'backward_row_norm',
                              printf(' (1e-9: %s)', percent(rate * solved_1e9 / solved)), '') AS solved, percent_range(rate_low, rate_high) AS range,
         percent(1.0 * false_claims / trials) AS wrong, percent(1.0 * gave_up / trials) AS gave_up,
         percent(1.0 * unsupported / trials) AS refused, duration("time.all.median") AS median,
         CASE WHEN time_ratio_problems >= least_problems THEN factor(time_ratio) || 'x (' || factor(time_ratio_low) ||
           '–' || factor(time_ratio_high) || ') n=' || time_ratio_problems
           WHEN time_ratio_problems > 0 THEN printf('- (%d of %d)', time_ratio_problems, trials - unsupported)
           END AS ratio, iif("error.p99" = 9e999, 'none', scientific("error.p99")) AS error
  FROM cells JOIN rule WHERE sweep = '' AND unsupported < trials
  UNION ALL
  SELECT "set", rowid, label || ' does not take these: ' || refusal, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL
  FROM cells WHERE sweep = '' AND unsupported = trials
  UNION ALL
  SELECT "set", 1e9 + rowid, printf('%s sweep %s (%d cells): worst %s, average %s, best %s; by the paper''s ' ||
           'criterion %s / %s / %s', solver, sweep, cells, percent(worst), percent(average), percent(best),
         percent("criterion.worst"), percent("criterion.average"), percent("criterion.best")),
         NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL
  FROM sweeps)
SELECT name || printf(', %d problem%s', problems, iif(problems = 1, '', 's')) AS heading, '  ' || solver AS solver,
       solved, range, wrong, gave_up, refused, median, ratio, error
FROM rows JOIN set_facts f ON f.name = "set" WHERE NOT hard ORDER BY f.rowid, place;
CREATE TEMP VIEW terminal_hard AS
SELECT NULL AS heading, solver, SUM(outcome = 'solved') AS solved, SUM(outcome = 'solved' AND error <= 1e-9) AS to_1e9,
       SUM(outcome = 'rightly_unsolvable') AS no_solution,
       SUM(outcome = 'false_claim') AS wrong, SUM(outcome = 'wrongly_unsolvable') AS denied,
       SUM(outcome = 'missed') AS missed, SUM(outcome = 'solved_unclaimed') AS unsaid,
       SUM(outcome = 'gave_up_unsolvable') AS gave_up, SUM(outcome = 'undecided') AS unknown,
       SUM(outcome = 'refused') AS refused
FROM hard_cases GROUP BY solver ORDER BY SUM(outcome IN ('solved', 'rightly_unsolvable')) DESC, solver;
