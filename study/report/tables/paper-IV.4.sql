-- Table IV.4 of the paper: running time of Experiment 6, copositive problems [s]
-- Mean, standard deviation and maximum, published beside measured: of the best parameterisation and of all together.
-- Our best one solves the largest share of the even trials; its numbers are those of the odd trials. time_solved is
-- the time of the problems that are solved by the rule in solved_by (see Table IV.1), time_all that of all problems. n
-- is the number of our values, over all parameterisations. Seconds of 2012 and of this machine cannot be compared, but
-- ratios between solvers can.
SELECT * FROM paper_means WHERE "table" = 'IV.4'
