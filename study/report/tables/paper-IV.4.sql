-- Table IV.4 of the paper: running time of Experiment 6, copositive problems [s]
-- Mean, standard deviation and maximum at the best parameterisation (chosen on the even trials, measured on the odd ones) and over all of them, published beside measured. Seconds of 2012 and of this machine are not compared; ratios between solvers are.
SELECT * FROM paper_means WHERE "table" = 'IV.4'
