-- How much of the plan is there
-- Cells (set, trial, solver parameterisation) that the runs planned, and how many are done.
SELECT name AS "set", kind, problems, n_min, n_max, planned, done, 1.0 * done / planned AS share FROM set_facts
