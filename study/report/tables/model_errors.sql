-- Three errors of soft contacts
-- Of each solver on a set of soft contacts whose hard version, changed{of=SET,by=hard}, is in the store too: the residual on the solver's own model, the relaxation's difference (convex model against Coulomb's cone of as soft contacts) and the softness's (Coulomb's friction, soft against hard), each at the contact that moves most differently. The last two are the set's, from verified answers.
WITH errors AS (
  SELECT "set", COUNT(relaxation_m_per_s) AS relaxed, median(relaxation_m_per_s) AS relaxation_median_m_per_s,
         MAX(relaxation_m_per_s) AS relaxation_max_m_per_s, COUNT(softness_m_per_s) AS softened,
         median(softness_m_per_s) AS softness_median_m_per_s, MAX(softness_m_per_s) AS softness_max_m_per_s
  FROM model_errors GROUP BY "set")
SELECT e."set", s.name || iif(s.settings = '', '', '{' || s.settings || '}') AS solver, j.model, COUNT(*) AS steps,
       SUM(j.verdict = 'solved') AS solved, median(v.velocity_residual_m_per_s) AS solver_median_m_per_s,
       MAX(v.velocity_residual_m_per_s) AS solver_max_m_per_s, relaxed, relaxation_median_m_per_s,
       relaxation_max_m_per_s, softened, softness_median_m_per_s, softness_max_m_per_s
FROM errors e JOIN sets ON sets.name = e."set" JOIN judged j ON j.set_id = sets.id
JOIN verdicts v USING (problem_id, solver_id, part) JOIN solvers s ON s.id = j.solver_id
WHERE s.sweep = '' GROUP BY e."set", s.id, j.model ORDER BY e."set", solver
