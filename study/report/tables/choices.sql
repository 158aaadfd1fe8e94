-- Which solver to use at which error
-- The recommended solver of each kind of contacts for answers of at most this error; an empty error is the verdict's own threshold. No solver: none is shown to be reliable.
SELECT contacts, error, MAX(CASE WHEN recommended THEN solver END) AS solver,
       MAX(CASE WHEN recommended THEN solved END) AS solved, MAX(CASE WHEN recommended THEN "of" END) AS of,
       MAX(CASE WHEN recommended THEN mean_time_s END) AS mean_time_s,
       SUM(reliability = 'reliable') AS reliable_solvers
FROM choices GROUP BY contacts, error ORDER BY MIN(place)
