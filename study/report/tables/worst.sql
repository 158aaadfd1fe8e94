-- The worst problems of each solver
-- At most three for each set and solver, false claims first, then by error, each with the command that repeats it.
SELECT * FROM worst
