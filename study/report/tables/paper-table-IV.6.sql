-- Table IV.6: normal violation in solved problems of Experiment 6, with friction [m/s]
-- Mean (standard deviation) maximum of the best parameterisation and of all; of what the paper's criterion takes for solved, or all.
SELECT solver, exp, parameters, published, ours FROM paper_printed_means WHERE "table" = 'IV.6'
