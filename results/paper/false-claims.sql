-- Answers claimed solved that the evaluation rejects, of every solver at single settings over all sets of the run.
-- sqlite3 -csv -header paper.db < results/paper/false-claims.sql > results/paper/tables/false-claims.csv
SELECT v.name AS solver, v.settings, v.library, count(*) AS answers, sum(j.claim = 'solved') AS claimed,
       sum(j.claim = 'solved' AND j.verdict IN ('wrong', 'unsolvable')) AS false_claims,
       count(DISTINCT CASE WHEN j.claim = 'solved' AND j.verdict IN ('wrong', 'unsolvable') THEN j.set_id END)
         AS "on_sets"
FROM solvers v JOIN judged j ON j.solver_id = v.id
WHERE v.sweep = ''
GROUP BY 1, 2, 3;
