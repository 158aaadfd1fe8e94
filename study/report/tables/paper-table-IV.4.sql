-- Table IV.4: running time of Experiment 6, with friction [s]
-- Mean (standard deviation) maximum of the best parameterisation and of all; of what the paper's criterion takes for solved, or all. our_answers: how many of ours the numbers are of.
SELECT solver, exp, problems, parameters, published, ours, our_answers FROM paper_printed_means WHERE "table" = 'IV.4'
