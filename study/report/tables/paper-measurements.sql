-- Times and violations of every experiment of the paper
-- Of which the paper prints Experiment 6 only.
-- only in tables/
SELECT * FROM paper_measurements
