-- The sweeps on the paper's sets: `paper_rates` (worst, average and best share solved over the parameterisations of
-- each) and `paper_measurements` (their times and violations), from `paper_cells`, `paper_counts` and `paper_spreads`.
-- A sweep's best is chosen on the even trials and counted on the odd ones; "worst_held_out" is the odd trials' share of
-- the cell that is worst on the even ones: a range free of the selection that makes the difference of best and worst
-- grow with the number of cells.
-- Parameterisations with the sweep that they are of; the instruction-set level, library and version belong to its name
-- where the store has it at several. One refused problem leaves a sweep without shares: a refusal is no failure to
-- solve.
CREATE TEMP TABLE paper_grids AS
WITH named AS (
  SELECT *, label ||
         iif(MIN(isa) OVER labels <> MAX(isa) OVER labels, ' at ' || isa, '') ||
         iif(MIN(build) OVER labels <> MAX(build) OVER labels, ' of ' || build, '') AS solver
  FROM paper_cells JOIN paper_counts USING (place)
  WHERE sweep <> '' AND refused < trials WINDOW labels AS (PARTITION BY label)),
shared AS (
  SELECT *, MAX(refused) OVER grid AS most_refused,
         iif(MAX(refused) OVER grid > 0, NULL, 1.0 * part / "of") AS share,
         iif(MAX(refused) OVER grid > 0, NULL, 1.0 * even_part / even_of) AS even_share,
         iif(MAX(refused) OVER grid > 0, NULL, 1.0 * odd_part / odd_of) AS odd_share
  FROM named WINDOW grid AS (PARTITION BY "set", solver, solved_by))
SELECT *, ROW_NUMBER() OVER (grid ORDER BY share IS NULL, share, place) = 1 AS worst,
       ROW_NUMBER() OVER (grid ORDER BY share IS NULL, share DESC, place) = 1 AS best,
       even_share IS NOT NULL AND
         ROW_NUMBER() OVER (grid ORDER BY even_share IS NULL, even_share DESC, place) = 1 AS chosen,
       ROW_NUMBER() OVER (grid ORDER BY even_share IS NULL, even_share, place) = 1 AS unlucky,
       ROW_NUMBER() OVER (grid ORDER BY place) = 1 AS first,
       ROW_NUMBER() OVER (grid ORDER BY refused DESC, place) = 1 AS refuses
FROM shared WINDOW grid AS (PARTITION BY "set", solver, solved_by);
CREATE TEMP TABLE paper_rates AS
SELECT kind, experiment, redundancy, reading, other_readings, paper_solver, "set", solver,
       MAX(iif(refuses AND refused > 0,
               'refused ' || refused || ' of ' || trials || iif(refusal = '', '', ': ' || refusal), '')) AS refused,
       COUNT(*) AS parameterisations, solved_by,
       MAX(iif(worst, share, NULL)) AS "worst.share", MAX(iif(worst, "of", NULL)) AS "worst.of",
       MAX(MIN(share), MIN(MAX(share), AVG(share))) AS "average.share",  -- the sum is rounded
       MIN(iif("of" > 0, "of", NULL)) AS "average.of",
       MAX(iif(best, share, NULL)) AS "best.share", MAX(iif(best, wilson_low(part, "of"), NULL)) AS "best.low",
       MAX(iif(best, wilson_high(part, "of"), NULL)) AS "best.high", MAX(iif(best, "of", NULL)) AS "best.of",
       sigma(share) AS sigma, MAX(iif(best AND share IS NOT NULL, settings, '')) AS best_settings,
       MAX(iif(chosen, odd_share, NULL)) AS "held_out.share", MAX(iif(chosen, odd_of, NULL)) AS "held_out.of",
       MAX(iif(unlucky, odd_share, NULL)) AS "worst_held_out.share",
       MAX(iif(unlucky, odd_of, NULL)) AS "worst_held_out.of",
       MIN(trials) AS trials, base, wrapped, grid AS sweep, isa, build,
       AVG(1.0 * false_claims / trials) AS "false_claims.share", MIN(trials) AS "false_claims.of",
       MAX(iif(first, 1.0 * unsolvable / trials, NULL)) AS "unsolvable.share",
       MAX(iif(first, trials, NULL)) AS "unsolvable.of",
       -- The share of the set's problems that have a solution, by theory: docs/explanation/paper-study.md.
       iif(kind = 'monotone' AND reading = 'multiple', CASE experiment WHEN 'exp3' THEN 0.849175293093
           WHEN 'exp4' THEN 0.962003909713 END, NULL) AS solvable,
       MAX(iif(chosen AND solved_by = 'verdict', 1.0 * odd_part / odd_trials, NULL)) AS "solved_odd.share",
       MAX(iif(chosen, odd_trials, NULL)) AS "solved_odd.of"
FROM paper_grids GROUP BY "set", solver, solved_by ORDER BY MIN(place), MIN(rowid);
-- A row for each share of a sweep.
CREATE TEMP VIEW paper_statistics AS
SELECT 'worst' AS statistic, "worst.share" AS share, "worst.of" AS "of", * FROM paper_rates
UNION ALL SELECT 'average', "average.share", "average.of", * FROM paper_rates
UNION ALL SELECT 'best', "best.share", "best.of", * FROM paper_rates
UNION ALL SELECT 'held_out', "held_out.share", "held_out.of", * FROM paper_rates;
-- Values of one problem depend on each other, so the pooled count says nothing of how well the mean is known; the
-- problems do. The sum of a problem's deviations over at most c parameterisations has a square of at most c times the
-- sum of their squares (Cauchy and Schwarz), so the variance of the pooled mean is at most sigma^2 / (n / c), however
-- the values of a problem depend on each other. sigma is that of the pooled values: within the parts, and between them.
CREATE TEMP TABLE paper_measurements AS
WITH spreads AS (
  SELECT g.kind, g.experiment, g.redundancy, g.reading, g.other_readings, g.paper_solver, g."set", g.solver, g.place,
         g.chosen, g.settings, s.*, SUM(n * mean) OVER cells / SUM(n) OVER cells AS pooled
  FROM paper_grids g JOIN paper_spreads s ON s.cell = g.place AND s.by = g.solved_by
  WHERE g.most_refused = 0 WINDOW cells AS (PARTITION BY g."set", g.solver, s.quantity, s.by))
SELECT kind, experiment, redundancy, reading, other_readings, paper_solver, "set", solver,
       COUNT(*) AS parameterisations, quantity, by AS solved_by, MAX(iif(chosen, settings, '')) AS best_settings,
       MAX(iif(chosen, odd_n, NULL)) AS "best.n", MAX(iif(chosen, odd_mean, NULL)) AS "best.mean",
       MAX(iif(chosen, odd_sigma, NULL)) AS "best.sigma", MAX(iif(chosen, odd_max, NULL)) AS "best.max",
       SUM(n) AS "all.n", MAX(pooled) AS "all.mean",
       sqrt((TOTAL((n - 1) * sigma * sigma) +
             TOTAL(n * (mean - pooled) * (mean - pooled))) / (SUM(n) - 1)) AS "all.sigma",
       MAX(max) AS "all.max", 1.0 * SUM(n) / SUM(n > 0) AS "all.problems"
FROM spreads GROUP BY "set", solver, quantity, by ORDER BY MIN(place), quantity, by;
-- Tables IV.1 and IV.2 of the paper with our numbers beside the published ones, and tables IV.3 to IV.6.
CREATE TEMP VIEW paper_shares AS
SELECT p."table", p.title AS experiment, r.redundancy, p.solver AS paper_solver, r.solver, r.solved_by,
       p.worst AS published_worst, p.average AS published_average, p.best AS published_best,
       r."worst.share" AS worst, r."average.share" AS average, r."best.share" AS best,
       r."best.low" AS best_low, r."best.high" AS best_high, r."held_out.share" AS held_out, r.sigma,
       r.parameterisations, r."average.of" AS trials, r.best_settings, r.refused
FROM published p LEFT JOIN paper_rates r
  ON r.kind = p.kind AND r.experiment = p.experiment AND r.paper_solver = p.solver AND r.other_readings = ''
WHERE p."table" IN ('IV.1', 'IV.2') AND p.quantity = 'rate' AND EXISTS (SELECT 1 FROM paper_rates)
UNION ALL
SELECT iif(r.kind = 'monotone', 'IV.1', 'IV.2'), r.experiment, r.redundancy, NULL, r.solver, r.solved_by, NULL, NULL,
       NULL, r."worst.share", r."average.share", r."best.share", r."best.low", r."best.high", r."held_out.share",
       r.sigma, r.parameterisations, r."average.of", r.best_settings, r.refused
FROM paper_rates r WHERE r.paper_solver IS NULL AND r.other_readings = '';
CREATE TEMP VIEW paper_means AS
SELECT p."table", p.title AS experiment, m.redundancy, p.quantity, p.solver AS paper_solver, m.solver, m.solved_by,
       p.best_mean AS published_best_mean, p.best_sigma AS published_best_sigma, p.best_max AS published_best_max,
       m."best.mean" AS best_mean, m."best.sigma" AS best_sigma, m."best.max" AS best_max, m."best.n" AS best_n,
       p.all_mean AS published_all_mean, p.all_sigma AS published_all_sigma, p.all_max AS published_all_max,
       m."all.mean" AS all_mean, m."all.sigma" AS all_sigma, m."all.max" AS all_max, m."all.n" AS n, m.best_settings
FROM published p LEFT JOIN paper_measurements m
  ON m.kind = p.kind AND m.experiment = p.experiment AND m.paper_solver = p.solver AND m.quantity = p.quantity
     AND m.other_readings = ''
WHERE p."table" IN ('IV.3', 'IV.4', 'IV.5', 'IV.6') AND EXISTS (SELECT 1 FROM paper_rates);
-- The tables as the paper prints them, from the views above: by the criterion of claimed answers; in Experiment 6 of
-- `regularized` with the paper's own test, else of the sweep of the most trials. First the shares: a row for each
-- experiment and reading, with worst/average/best in percent.
CREATE TEMP VIEW paper_printed_shares AS
WITH ranked AS (
  SELECT *, coalesce(redundancy, MAX(redundancy) OVER (PARTITION BY "table", experiment), '') AS reading,
         ROW_NUMBER() OVER (PARTITION BY "table", experiment, paper_solver, redundancy ORDER BY
           solved_by IS 'criterion' DESC, spec_option(solver, 'test') IS 'tried' DESC, trials DESC) AS choice
  FROM paper_shares WHERE paper_solver IS NOT NULL),
figures AS (
  SELECT "table", experiment, NULL AS reading, paper_solver || ' published' AS cell, published_worst AS worst,
         published_average AS average, published_best AS best FROM ranked WHERE choice = 1
  UNION ALL
  SELECT "table", experiment, reading, paper_solver || ' ours', worst, average, best FROM ranked
  WHERE choice = 1 AND best IS NOT NULL),
texts AS (
  SELECT *, iif(worst IS NULL, '-', printf('%.4g', 100 * worst)) || '/' ||
            iif(average IS NULL, '-', printf('%.4g', 100 * average)) || '/' || printf('%.4g', 100 * best) AS text
  FROM figures)
SELECT r."table", replace(r.experiment, ' at ', ' ') || iif(r.reading = 'combination', ' c', '') AS exp,
       MAX(iif(cell = 'Lemke published', text, NULL)) AS Lemke_published,
       MAX(iif(cell = 'Lemke ours', text, NULL)) AS Lemke_ours,
       MAX(iif(cell = 'PATH published', text, NULL)) AS PATH_published,
       MAX(iif(cell = 'PATH ours', text, NULL)) AS PATH_ours,
       MAX(iif(cell = 'IP published', text, NULL)) AS IP_published, MAX(iif(cell = 'IP ours', text, NULL)) AS IP_ours,
       iif(MIN(r.trials) < MAX(r.trials), printf('%d-%d', MIN(r.trials), MAX(r.trials)), MAX(r.trials)) AS our_trials
FROM ranked r JOIN texts t ON r.choice = 1 AND t."table" = r."table" AND t.experiment = r.experiment
                              AND coalesce(t.reading, r.reading) = r.reading
GROUP BY r."table", r.experiment, r.reading ORDER BY substr(r.experiment, 1, 1), length(r.experiment),
         r.experiment, r.reading = 'combination';
-- Then times and violations, redundant contacts as multiples: mean (standard deviation) maximum.
CREATE TEMP VIEW paper_printed_means AS
WITH ranked AS (
  SELECT *, ROW_NUMBER() OVER (PARTITION BY "table", experiment, quantity, paper_solver ORDER BY
              redundancy IS 'multiple' DESC, solved_by IS 'criterion' DESC, spec_option(solver, 'test') IS 'tried' DESC,
              n DESC) AS choice
  FROM paper_means),
figures AS (
  SELECT *, 'best' AS parameters, published_best_mean AS mean, published_best_sigma AS sigma, published_best_max AS max,
         best_mean AS our_mean, best_sigma AS our_sigma, best_max AS our_max, best_n AS our_n FROM ranked WHERE choice = 1
  UNION ALL
  SELECT *, 'all', published_all_mean, published_all_sigma, published_all_max, all_mean, all_sigma, all_max, n
  FROM ranked WHERE choice = 1)
SELECT "table", paper_solver AS solver, replace(experiment, ' at ', ' ') AS exp,
       iif(quantity = 'time_all', 'all', 'solved') AS problems, parameters,
       iif(mean IS NULL, NULL, replace(printf('%.6g (%.6g) %.6g', mean, sigma, max), 'e-0', 'e-')) AS published,
       iif(redundancy = 'multiple' AND our_mean IS NOT NULL,
           replace(printf('%.3g (%.3g) %.3g', our_mean, our_sigma, our_max), 'e-0', 'e-'), NULL) AS ours,
       iif(redundancy = 'multiple' AND our_mean IS NOT NULL, our_n, NULL) AS our_answers
FROM figures WHERE mean IS NOT NULL OR our_mean IS NOT NULL
ORDER BY paper_solver = 'IP', paper_solver, quantity = 'time_all', length(experiment), experiment,
         parameters DESC;
