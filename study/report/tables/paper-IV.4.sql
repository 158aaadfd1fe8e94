-- Table IV.4 of the paper: running time of Experiment 6, copositive problems [s]
-- Mean, standard deviation and maximum, published beside measured: of the best parameterisation (ours is chosen on the even trials and measured on the odd ones) and of all parameterisations together. time_solved: of the problems that count as solved by the rule solved_by (see Table IV.1); time_all: of all. n: all values of ours together. Seconds of 2012 and of this machine cannot be compared, but ratios between solvers can.
SELECT * FROM paper_means WHERE "table" = 'IV.4'
