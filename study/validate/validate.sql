CREATE TABLE sets (place INTEGER PRIMARY KEY, name TEXT);
CREATE TABLE solvers (place INTEGER PRIMARY KEY, name TEXT, ours INTEGER);  -- the last is what is known by proof
CREATE TABLE answers (problem INTEGER, solver INTEGER, "set" INTEGER, trial INTEGER, standing TEXT,
                      PRIMARY KEY (problem, solver)) WITHOUT ROWID;
-- Both verified where the velocity is unique, and apart.
CREATE TABLE other_velocities (problem INTEGER, a INTEGER, b INTEGER, PRIMARY KEY (problem, a, b)) WITHOUT ROWID;
CREATE VIEW met AS
SELECT n."set" AS place, n.trial, n.solver AS native, r.solver AS reference, CASE
         WHEN n.standing = 'wrong' THEN iif(r.standing = 'wrong', 'both_wrong', 'native_wrong')
         WHEN r.standing = 'wrong' THEN 'reference_wrong'
         WHEN n.standing = 'right' AND r.standing = 'right' AND v.a IS NULL THEN 'agree'
         ELSE 'undecided' END AS outcome, v.a IS NOT NULL AS apart
FROM answers n JOIN solvers ON solvers.place = n.solver AND ours
     JOIN answers r ON r.problem = n.problem AND r.solver IN (SELECT place FROM solvers WHERE NOT ours)
     LEFT JOIN other_velocities v ON v.problem = n.problem AND v.a = n.solver AND v.b = r.solver;
CREATE VIEW counts AS
SELECT place, native, reference, COUNT(*) AS compared, SUM(outcome = 'agree') AS agree,
       SUM(outcome = 'native_wrong') AS native_wrong, SUM(outcome = 'reference_wrong') AS reference_wrong,
       SUM(outcome = 'both_wrong') AS both_wrong, SUM(outcome = 'undecided') AS undecided
FROM met GROUP BY place, native, reference;
CREATE VIEW pairs AS
SELECT s.name AS "set", n.name AS native, r.name AS reference, compared, agree, native_wrong, reference_wrong,
       both_wrong, undecided
FROM counts c JOIN sets s USING (place) JOIN solvers n ON n.place = native JOIN solvers r ON r.place = reference
ORDER BY c.place, n.place, r.place;
CREATE VIEW over_sets AS
SELECT n.name AS native, r.name AS reference, SUM(compared) AS compared, SUM(agree) AS agree,
       SUM(native_wrong) AS native_wrong, SUM(reference_wrong) AS reference_wrong, SUM(both_wrong) AS both_wrong,
       SUM(undecided) AS undecided
FROM counts JOIN solvers n ON n.place = native JOIN solvers r ON r.place = reference
GROUP BY n.place, r.place ORDER BY n.place, r.place;
CREATE VIEW totals AS
SELECT native, printf('%d reference%s', COUNT(*), iif(COUNT(*) = 1, '', 's')) AS reference, SUM(compared) AS compared,
       SUM(agree) AS agree, SUM(native_wrong) AS native_wrong, SUM(reference_wrong) AS reference_wrong,
       SUM(both_wrong) AS both_wrong, SUM(undecided) AS undecided
FROM over_sets JOIN solvers ON name = native AND ours GROUP BY native ORDER BY place;
CREATE VIEW disagreements AS
SELECT m.place, s.name AS "set", m.trial, n.name AS ours, r.name AS reference, m.outcome
FROM met m JOIN sets s USING (place) JOIN solvers n ON n.place = native JOIN solvers r ON r.place = reference
WHERE outcome IN ('native_wrong', 'reference_wrong', 'both_wrong') OR (outcome = 'undecided' AND apart)
ORDER BY m.place, m.trial, n.name, r.name;
