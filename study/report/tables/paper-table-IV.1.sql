-- Table IV.1: share solved, without friction [%]
-- Worst/average/best over each solver's parameterisations, by the paper's criterion of claimed answers. c: redundant contacts are combinations of several others, not multiples of one. our_trials: how many problems each share of ours is of.
SELECT exp, Lemke_published, Lemke_ours, PATH_published, PATH_ours, IP_published, IP_ours, our_trials FROM paper_printed_shares WHERE "table" = 'IV.1'
