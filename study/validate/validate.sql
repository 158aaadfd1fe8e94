-- Over `study_sets` and `study_solvers`, of which the last is what is known by proof; the connection is the store's.
-- An answer is "right" when it is verified as a solution, or was said to be unsolvable and a checked proof confirms it;
-- "wrong" when it is a false claim; "silent" when its solver gave up or missed a solution.
CREATE TEMP TABLE compared (problem INTEGER, solver INTEGER, "set" INTEGER, trial INTEGER, worth TEXT,
                            PRIMARY KEY (problem, solver)) WITHOUT ROWID;
INSERT INTO compared
WITH met AS (SELECT p.id, p.theory, s.place AS "set", p.trial FROM study_sets s
             JOIN problems p ON p.set_id = s.id AND p.seed = s.seed AND p.trial < s.trials)
SELECT met.id, v.place, "set", met.trial,
       CASE WHEN verdict = 'wrong' THEN 'wrong'
            WHEN verdict = 'solved' OR (verdict = 'unsolvable' AND claim = 'unsolvable') THEN 'right'
            ELSE 'silent' END
FROM met JOIN judged j ON j.problem_id = met.id JOIN study_solvers v ON v.id = j.solver_id WHERE claim <> 'unsupported'
UNION ALL
SELECT id, (SELECT MAX(place) FROM study_solvers), "set", trial, 'right' FROM met
WHERE theory = 'solvable' OR EXISTS (SELECT 1 FROM certificates c WHERE c.problem_id = met.id AND certificate <> 'open')
   OR EXISTS (SELECT 1 FROM verdicts WHERE problem_id = met.id AND farkas_checked = 1);
-- Solved where theory has one velocity, if the size allows: without friction, and with a definite inertia.
CREATE TEMP VIEW verified AS
SELECT problem, "set", c.trial, s.place, s.id, complementarity_j, violation_m_per_s, min_z
FROM compared c JOIN problems p ON p.id = problem AND p.theory = 'solvable' AND p.nc = p.n
     JOIN study_solvers s ON s.place = solver JOIN verdicts v ON v.problem_id = problem AND v.solver_id = s.id
WHERE worth = 'right';
-- Both verified where the velocity is unique, and apart.
CREATE TEMP TABLE other_velocities (problem INTEGER, a INTEGER, b INTEGER, PRIMARY KEY (problem, a, b)) WITHOUT ROWID;
CREATE TEMP VIEW met AS
SELECT sets.name AS "set", n."set" AS set_place, n.trial, ours.name AS native, n.solver AS native_place,
       theirs.name AS reference, r.solver AS reference_place, CASE
         WHEN n.worth = 'wrong' THEN iif(r.worth = 'wrong', 'both_wrong', 'native_wrong')
         WHEN r.worth = 'wrong' THEN 'reference_wrong'
         WHEN n.worth = 'right' AND r.worth = 'right' AND v.a IS NULL THEN 'agree'
         ELSE 'undecided' END AS outcome, v.a IS NOT NULL AS apart
FROM compared n JOIN study_solvers ours ON ours.place = n.solver AND ours.ours
     JOIN compared r ON r.problem = n.problem JOIN study_solvers theirs ON theirs.place = r.solver AND NOT theirs.ours
     JOIN study_sets sets ON sets.place = n."set"
     LEFT JOIN other_velocities v ON v.problem = n.problem AND v.a = n.solver AND v.b = r.solver;
CREATE TEMP VIEW disagreements AS
SELECT set_place AS place, "set", trial, native AS ours, reference, outcome FROM met
WHERE outcome IN ('native_wrong', 'reference_wrong', 'both_wrong') OR (outcome = 'undecided' AND apart)
ORDER BY place, trial, ours, reference;
