-- Runs in the store once validate() has filled `study_sets` and `study_solvers`, numbered by `place`. The solver with
-- the highest place is the reference "truth", right wherever theory, a certificate or a checked proof gives the truth.
-- The worth of an answer: "right" when it is verified as a solution, or claims "unsolvable" and a certificate or a
-- checked proof confirms it; "wrong" when it falsely claims "solved"; else "silent", also when it falsely claims
-- "unsolvable". Refusals have no row.
CREATE TEMP TABLE compared (problem INTEGER, solver INTEGER, "set" INTEGER, trial INTEGER, worth TEXT,
                            model TEXT, PRIMARY KEY (problem, solver)) WITHOUT ROWID;
INSERT INTO compared
WITH chosen AS (SELECT p.id, p.theory, s.place AS "set", p.trial FROM study_sets s
                JOIN problems p ON p.set_id = s.id AND p.seed = s.seed AND p.trial < s.trials)
SELECT chosen.id, v.place, "set", chosen.trial,
       CASE WHEN verdict = 'wrong' THEN 'wrong'
            WHEN verdict = 'solved' OR (verdict = 'unsolvable' AND claim = 'unsolvable') THEN 'right'
            ELSE 'silent' END, model
FROM chosen JOIN judged j ON j.problem_id = chosen.id JOIN study_solvers v ON v.id = j.solver_id
WHERE claim <> 'unsupported'
UNION ALL
SELECT id, (SELECT MAX(place) FROM study_solvers), "set", trial, 'right', 'pyramid' FROM chosen
WHERE theory = 'solvable'
   OR EXISTS (SELECT 1 FROM certificates WHERE problem_id = chosen.id AND certificate <> 'open')
   OR EXISTS (SELECT 1 FROM verdicts WHERE problem_id = chosen.id AND farkas_checked = 1);
-- Verified answers to frictionless contact problems that theory proves solvable, with the errors that
-- VelocityAgreement takes. Its applies() says which of these problems have only one velocity and are small enough.
CREATE TEMP VIEW verified AS
SELECT problem, "set", c.trial, s.place, s.id, complementarity_j, violation_m_per_s, min_z
FROM compared c JOIN problems p ON p.id = problem AND p.theory = 'solvable' AND p.nc = p.n
     JOIN study_solvers s ON s.place = solver JOIN verdicts v ON v.problem_id = problem AND v.solver_id = s.id
WHERE worth = 'right';
-- Pairs of verified answers (places of their solvers, in both orders) whose velocities differ although the problem has
-- only one. Filled by validate().
CREATE TEMP TABLE other_velocities (problem INTEGER, a INTEGER, b INTEGER, PRIMARY KEY (problem, a, b)) WITHOUT ROWID;
-- The outcome for each problem, each solver of ours and each reference that both took it. Answers that are both right
-- but have different velocities are undecided.
CREATE TEMP VIEW met AS
SELECT sets.name AS "set", n."set" AS set_place, n.trial, ours.name AS native, n.solver AS native_place,
       theirs.name AS reference, r.solver AS reference_place, CASE
         WHEN n.worth = 'wrong' THEN iif(r.worth = 'wrong', 'both_wrong', 'native_wrong')
         WHEN r.worth = 'wrong' THEN 'reference_wrong'
         WHEN n.worth = 'right' AND r.worth = 'right' AND n.model = r.model AND v.a IS NULL THEN 'agree'
         ELSE 'undecided' END AS outcome, v.a IS NOT NULL AS apart
FROM compared n JOIN study_solvers ours ON ours.place = n.solver AND ours.ours
     JOIN compared r ON r.problem = n.problem JOIN study_solvers theirs ON theirs.place = r.solver AND NOT theirs.ours
     JOIN study_sets sets ON sets.place = n."set"
     LEFT JOIN other_velocities v ON v.problem = n.problem AND v.a = n.solver AND v.b = r.solver;
-- Outcomes with a wrong answer or with different velocities.
CREATE TEMP VIEW disagreements AS
SELECT set_place AS place, "set", trial, native AS ours, reference, outcome FROM met
WHERE outcome IN ('native_wrong', 'reference_wrong', 'both_wrong') OR (outcome = 'undecided' AND apart)
ORDER BY place, trial, ours, reference;
