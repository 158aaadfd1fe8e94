-- One row for each line of published.csv below the heading; an empty field is NULL. No field has a comma or a quote.
CREATE TEMP TABLE published AS
WITH lines AS (
  SELECT replace('["' || replace(value, ',', '","') || '"]', '""', 'null') AS f
  FROM json_each('["' || replace(trim('@published@', char(10)), char(10), '","') || '"]') WHERE key > 0)
SELECT json_extract(f, '$[0]') AS "table", json_extract(f, '$[1]') AS kind, json_extract(f, '$[2]') AS experiment,
       json_extract(f, '$[3]') AS title, json_extract(f, '$[4]') AS solver, json_extract(f, '$[5]') AS quantity,
       json_extract(f, '$[6]') + 0.0 AS worst, json_extract(f, '$[7]') + 0.0 AS average,
       json_extract(f, '$[8]') + 0.0 AS best, json_extract(f, '$[9]') + 0.0 AS best_mean,
       json_extract(f, '$[10]') + 0.0 AS best_sigma, json_extract(f, '$[11]') + 0.0 AS best_max,
       json_extract(f, '$[12]') + 0.0 AS all_mean, json_extract(f, '$[13]') + 0.0 AS all_sigma,
       json_extract(f, '$[14]') + 0.0 AS all_max
FROM lines;
-- One row for each cell (a solver with its settings on a set) on a set of the paper, with the names taken apart.
-- A set is named 'paper/<kind>/<experiment>{<options>}'. Where the paper is ambiguous, an option chooses a reading.
--   redundancy      reading of how redundant contacts are made; '' in Experiments 1 and 3, which have none
--   other_readings  all other options of the set
--   grid            name of the sweep, '' for a single setting; 'paper' of the sweep 'paper{engine=kernel}'
--   base            solver with the settings that all cells of the sweep share, 'lemke{engine=kernel}' there
--   label           base, and the sweep's name unless that is 'paper'
--   wrapped         solver that `regularized` wraps, '' for other solvers
--   paper_solver    the paper's name of the solver, or of the one that it wraps; NULL where the paper has none
--   place           number of the cell, from 0
CREATE TEMP TABLE paper_cells AS
WITH of_paper AS (
  SELECT rowid - 1 AS place, "set", label AS full_name, solver AS name,
         solver || iif(settings = '', '', '{' || settings || '}') AS spec, sweep, settings, isa,
         library || ' ' || version AS build, trials, unsupported AS refused, refusal,
         unsolvable_problems AS unsolvable, false_claims
  FROM cells WHERE "set" LIKE 'paper/%'),
named AS (
  SELECT *, spec_name("set") AS problems, substr(spec_name("set"), 7, instr(substr("set", 7), '/') - 1) AS kind,
         coalesce(spec_option("set", 'redundancy'), 'multiple') AS reading,
         iif(sweep = '', '', spec_name(sweep)) AS grid,
         iif(sweep = '', spec, name || substr(sweep, length(spec_name(sweep)) + 1)) AS base
  FROM of_paper),
taken_apart AS (
  SELECT *, substr(problems, length(kind) + 8) AS experiment,
         iif(spec_name(base) = 'regularized', coalesce(spec_option(base, 'solver'), 'lemke'), '') AS wrapped
  FROM named WHERE kind IN ('monotone', 'copositive'))
SELECT kind, experiment, iif(experiment IN ('exp1', 'exp3'), '', reading) AS redundancy, reading,
       trim(replace(',' || rtrim(substr("set", length(problems) + 2), '}') || ',',
                    ',redundancy=' || reading || ',', ','), ',') AS other_readings,
       CASE spec_name(iif(wrapped = '', base, wrapped)) WHEN 'lemke' THEN 'Lemke' WHEN 'path' THEN 'PATH'
         WHEN 'primal_dual' THEN 'IP' END AS paper_solver,
       "set", full_name, base || iif(grid IN ('', 'paper'), '', ' (sweep ' || grid || ')') AS label, base, wrapped,
       grid, spec, name, sweep, iif(settings = '', 'defaults', settings) AS settings, isa, build, trials, refused,
       refusal, unsolvable, false_claims, solver_setting(spec, 'pivot_tolerance') AS pivot_tolerance,
       solver_setting(spec, 'zero_tolerance') AS zero_tolerance, place
FROM taken_apart
WHERE experiment IN ('exp1', 'exp2', 'exp3', 'exp4', 'exp5-1e5', 'exp5-1e8', 'exp5-1e10', 'exp6-1e5', 'exp6-1e8',
                     'exp6-1e10', 'extra100')
ORDER BY place;
