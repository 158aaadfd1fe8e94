-- Which solver to use at which error
-- The recommended solver of each kind of contacts for answers of at most this error; an empty error is the verdict's own threshold. Where the solver is empty, none is shown to be reliable.
SELECT contacts, error, MAX(iif(recommended, solver, NULL)) AS solver,
       MAX(iif(recommended, "solved.part", NULL)) AS solved, MAX(iif(recommended, "solved.whole", NULL)) AS of,
       MAX(iif(recommended, "mean_time_s.value", NULL)) AS mean_time_s,
       SUM(reliability = 'reliable') AS reliable_solvers
FROM contenders GROUP BY contacts, error ORDER BY MIN(rowid)
