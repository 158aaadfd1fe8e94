-- Table IV.3 of the paper: running time of Experiment 6, monotone problems [s]
-- Of the best parameterisation (chosen on the even trials, measured on the odd ones) and of all together, over n values of ours.
-- only in tables/
SELECT * FROM paper_means WHERE "table" = 'IV.3'
