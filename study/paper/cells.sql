DROP TABLE IF EXISTS temp.published;
DROP TABLE IF EXISTS temp.paper_cells;
-- One row for each line of published.csv below the heading. No field has a comma or a quote.
CREATE TEMP TABLE published AS
WITH lines AS (
  SELECT key, '["' || replace(value, ',', '","') || '"]' AS fields
  FROM json_each('["' || replace(trim('@published@', char(10)), char(10), '","') || '"]') WHERE key > 0),
fields AS (
  SELECT l.key, f.key AS place, iif(f.value GLOB '[0-9]*' AND f.key > 5, CAST(f.value AS REAL), nullif(f.value, '')) AS field
  FROM lines l JOIN json_each(l.fields) f)
SELECT MAX(field) FILTER (WHERE place = 0) AS "table", MAX(field) FILTER (WHERE place = 1) AS kind,
       MAX(field) FILTER (WHERE place = 2) AS experiment, MAX(field) FILTER (WHERE place = 3) AS title,
       MAX(field) FILTER (WHERE place = 4) AS solver, MAX(field) FILTER (WHERE place = 5) AS quantity,
       MAX(field) FILTER (WHERE place = 6) AS worst, MAX(field) FILTER (WHERE place = 7) AS average,
       MAX(field) FILTER (WHERE place = 8) AS best, MAX(field) FILTER (WHERE place = 9) AS best_mean,
       MAX(field) FILTER (WHERE place = 10) AS best_sigma, MAX(field) FILTER (WHERE place = 11) AS best_max,
       MAX(field) FILTER (WHERE place = 12) AS all_mean, MAX(field) FILTER (WHERE place = 13) AS all_sigma,
       MAX(field) FILTER (WHERE place = 14) AS all_max
FROM fields GROUP BY key ORDER BY key;
-- Every parameterisation on a set of the paper, the names taken apart: a set's kind, experiment and readings; the solver
-- of the paper that a solver stands for, or the one that it wraps. A cell of a sweep is called by its solver with what
-- all cells of the sweep share off their defaults, as "paper{engine=kernel}" has it. Readings of redundancy differ where
-- contacts are dependent: not in Experiments 1 and 3.
CREATE TEMP TABLE paper_cells AS
WITH named AS (
  SELECT *, spec_name("set") AS problems, substr(spec_name("set"), 7, instr(substr("set", 7), '/') - 1) AS kind,
         coalesce(spec_option("set", 'redundancy'), 'multiple') AS reading,
         iif(sweep = '', '', spec_name(sweep)) AS grid,
         iif(sweep = '', spec, name || substr(sweep, length(spec_name(sweep)) + 1)) AS base
  FROM paper_answers),
wrapped AS (
  SELECT *, substr(problems, length(kind) + 8) AS experiment,
         iif(spec_name(base) = 'regularized', coalesce(spec_option(base, 'solver'), 'lemke'), '') AS wrapped
  FROM named WHERE kind IN ('monotone', 'copositive'))
SELECT kind, experiment, iif(experiment IN ('exp1', 'exp3'), '', reading) AS redundancy, reading,
       trim(replace(',' || rtrim(substr("set", length(problems) + 2), '}') || ',', ',redundancy=' || reading || ',', ','),
            ',') AS other_readings,
       CASE spec_name(iif(wrapped = '', base, wrapped)) WHEN 'lemke' THEN 'Lemke' WHEN 'path' THEN 'PATH'
         WHEN 'primal_dual' THEN 'IP' END AS paper_solver,
       "set", base || iif(grid IN ('', 'paper'), '', ' (sweep ' || grid || ')') AS label, base, wrapped,
       coalesce(spec_option(iif(wrapped = '', base, wrapped), 'rules') = '2012', 0) AS rules_2012, grid, spec, name, sweep,
       iif(settings = '', 'defaults', settings) AS settings, isa, build, trials, refused, refusal, unsolvable,
       false_claims, odd_solved, odd_trials, solver_setting(spec, 'pivot_tolerance') AS pivot_tolerance,
       solver_setting(spec, 'zero_tolerance') AS zero_tolerance, place
FROM wrapped
WHERE experiment IN ('exp1', 'exp2', 'exp3', 'exp4', 'exp5-1e5', 'exp5-1e8', 'exp5-1e10', 'exp6-1e5', 'exp6-1e8',
                     'exp6-1e10', 'extra100')
ORDER BY place;
