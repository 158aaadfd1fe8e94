CREATE TABLE sets (place INTEGER PRIMARY KEY, name TEXT);
CREATE TABLE solvers (place INTEGER PRIMARY KEY, name TEXT, ours INTEGER);  -- the last is what is known by proof
CREATE TABLE answers (problem INTEGER, solver INTEGER, "set" INTEGER, trial INTEGER, standing TEXT,
                      PRIMARY KEY (problem, solver)) WITHOUT ROWID;
-- Both verified where the velocity is unique, and apart.
CREATE TABLE other_velocities (problem INTEGER, a INTEGER, b INTEGER, PRIMARY KEY (problem, a, b)) WITHOUT ROWID;
CREATE VIEW met AS
SELECT sets.name AS "set", n."set" AS set_place, n.trial, ours.name AS native, n.solver AS native_place,
       theirs.name AS reference, r.solver AS reference_place, CASE
         WHEN n.standing = 'wrong' THEN iif(r.standing = 'wrong', 'both_wrong', 'native_wrong')
         WHEN r.standing = 'wrong' THEN 'reference_wrong'
         WHEN n.standing = 'right' AND r.standing = 'right' AND v.a IS NULL THEN 'agree'
         ELSE 'undecided' END AS outcome, v.a IS NOT NULL AS apart
FROM answers n JOIN solvers ours ON ours.place = n.solver AND ours.ours
     JOIN answers r ON r.problem = n.problem JOIN solvers theirs ON theirs.place = r.solver AND NOT theirs.ours
     JOIN sets ON sets.place = n."set"
     LEFT JOIN other_velocities v ON v.problem = n.problem AND v.a = n.solver AND v.b = r.solver;
CREATE VIEW disagreements AS
SELECT set_place AS place, "set", trial, native AS ours, reference, outcome FROM met
WHERE outcome IN ('native_wrong', 'reference_wrong', 'both_wrong') OR (outcome = 'undecided' AND apart)
ORDER BY place, trial, ours, reference;
