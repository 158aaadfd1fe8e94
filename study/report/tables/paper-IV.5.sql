-- Table IV.5 of the paper: normal violation of solved problems of Experiment 6, monotone problems [m/s]
-- Mean, standard deviation and maximum, published beside measured: of the best parameterisation (ours is chosen on the even trials and measured on the odd ones) and of all parameterisations together. By the criterion no violation can exceed 1e-3 m/s.
-- only in tables/
SELECT * FROM paper_means WHERE "table" = 'IV.5'
