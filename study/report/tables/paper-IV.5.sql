-- Table IV.5 of the paper: normal violation of solved problems of Experiment 6, monotone problems [m/s]
-- Mean, standard deviation and maximum at the best parameterisation (chosen on the even trials, measured on the odd ones) and over all of them, published beside measured. By the criterion no violation can exceed 1e-3 m/s.
SELECT * FROM paper_means WHERE "table" = 'IV.5'
