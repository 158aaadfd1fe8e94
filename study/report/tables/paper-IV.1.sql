-- Table IV.1 of the paper: share solved, monotone problems
-- Worst, average and best over each solver's parameterisations, published beside measured. Solved by the paper's criterion: normal violation below 1e-3 m/s and work gain below 1e-3 J, of all trials, of answers that the solver claims (criterion) or of any answer (criterion_any); by the verdict: every condition holds to 1e-4 relative, of the trials not proven unsolvable. held_out: the best parameterisation of the even trials, on the odd ones. Where no number of ours stands, the store has no such sweep.
-- only in tables/
SELECT * FROM paper_shares WHERE "table" = 'IV.1'
