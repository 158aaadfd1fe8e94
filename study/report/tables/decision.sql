-- Which solver to use
-- The solvers of each kind of contacts, the recommended one first, at the verdict's own threshold of error.
SELECT * FROM decision
