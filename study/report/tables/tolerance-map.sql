-- Share solved over the two tolerances of Lemke's algorithm
-- Each cell of the sweeps on the paper's sets that has both tolerances.
-- only in tables/
SELECT * FROM paper_tolerances
