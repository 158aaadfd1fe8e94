-- The claims of the paper, and what this project adds to them. Each comparison holds a quantity against a bound: terms
-- are "coefficient share trials ..." of a combination of shares, "mean sigma problems" twice of a ratio of means, or
-- "problems only_first only_second" of pairs. Sweeps with refusals take no part, nor do those that met less than half
-- as many problems as the largest sweep of their set: they decide nothing, and their comparisons would cost the others
-- power.
CREATE TEMP TABLE paper_claims AS
WITH claims(place, claim, every, statement, test, needs, cause) AS (VALUES
(1, 'monotone-easier', 1, 'Monotone (frictionless) problems are easier to solve than copositive (frictional) ones.',
 'Average share solved over a solver''s parameters: monotone less copositive is above 0, for every experiment, reading and measure.',
 'one sweep on both kinds of the same experiment', ''),
(2, 'regularisation-gain', 0, 'Regularisation raises the share solved (Experiment 6 against 5).',
 'Average over the parameters with regularisation, less that of the wrapped solver without, on the same problems, is above 0; where both were run at single settings, also in pairs (McNemar).',
 'a sweep of regularized on exp6 and of the solver it wraps on exp5', ''),
(3, 'regularisation-closes-gap', 0, 'Regularisation removes much of the advantage of monotone problems.',
 '“Much”: at least a third of it, as in the paper''s own averages at all three condition numbers. Two thirds of the advantage (average, monotone less copositive) in Experiment 5, less the advantage in Experiment 6, is above 0.',
 'sweeps of regularized on exp6 and of the solver it wraps on exp5, both kinds', ''),
(4, 'regularisation-cost', 0, 'Regularisation takes significant additional running time.',
 'Mean time per problem over all parameters with regularisation, over that of the wrapped solver without, on the same problems, is above 1.05.',
 'a timed sweep of regularized on exp6 and of the solver it wraps on exp5', ''),
(5, 'regularisation-false-claims', 0, 'Not in the paper, implied by its use: regularisation makes no more false claims than the solver it wraps.',
 'Share of answers claimed solved that are wrong, average over the parameters: with regularisation less without is below 1 point.',
 'a sweep of regularized on exp6 and of the solver it wraps on exp5', ''),
(6, 'redundancy-a-little', 0, 'Redundant contacts (Experiment 2) lower solubility a little.',
 'Average over the parameters, Experiment 1 less Experiment 2, lies between 0 and 10 points (the paper''s own averages fall by 3 to 9): the whole interval has to.',
 'one sweep on exp1 and exp2', ''),
(7, 'rank-far-more', 0, 'An inertia of reduced rank (Experiment 3) lowers solubility far more than redundant contacts do.',
 '“Far more”: at least twice as much. Average by the paper''s criterion: the drop from Experiment 1 to 3, less twice the drop from 1 to 2, is above 0. Explained when, monotone, Lemke at its best solves within 2 points of the share that has a solution at all.',
 'one sweep on exp1, exp2 and exp3',
 'With an inertia of reduced rank many problems have no solution, and of the others the criterion rejects right answers: its work test presupposes a regular inertia.'),
(8, 'exp4-above-exp3', 0, 'Experiment 4 (reduced inertia and redundant contacts) is solved more often than Experiment 3, counterintuitively.',
 'By the paper''s criterion: average and held-out best over the parameters of Experiment 4, less Experiment 3, are above 0. Explained when, monotone with contacts that are multiples, Lemke at its best solves within 2 points of the share that has a solution, in both experiments.',
 'one sweep on exp3 and exp4',
 'A problem without solution needs, generically, rank(N) > rank(G). Redundancy lowers rank(N), so fewer problems of Experiment 4 are unsolvable.'),
(9, 'lemke-best', 1, 'Lemke''s algorithm is the best of the three solvers by the share it solves.',
 'Share solved on the odd trials at the parameters chosen on the even ones: Lemke less PATH, and Lemke less the interior point method, is above 0 on every set; where both were run at single settings, also in pairs (McNemar). Equal shares leave a set undecided.',
 'sweeps of lemke and of primal_dual or path on the same set', ''),
(10, 'path-wider', 1, 'PATH is better than Lemke over a wider range of parameters on all criteria.',
 'On every set: average share of PATH less Lemke''s above 0, and the share on the odd trials at the parameters that are worst on the even ones likewise (a plain minimum would be lower for the larger grid); mean time of the solved problems and mean violation over all parameters, PATH over Lemke, below 1.',
 'sweeps of path and of lemke on the same set; PATH is installed by its users', ''),
(11, 'lemke-path-speed', 1, 'Lemke is much faster than PATH on monotone problems and much slower on copositive ones.',
 '“Much”: by a factor of 2. Mean time of the solved problems over all parameters, PATH over Lemke: above 2 on every monotone set, below 1/2 on every copositive one.',
 'sweeps of path and of lemke on the same set; PATH is installed by its users', ''),
(12, 'ip-robust', 0, 'The interior point method is extremely robust to its parameters.',
 '“Extremely”: its range over the parameters (share at the best less that at the worst) is less than a quarter of Lemke''s on the same set: a quarter of Lemke''s, less its own, is above 0. Best and worst are chosen on the even trials and compared on the odd ones, because plain ranges grow with the number of parameterisations by chance.',
 'sweeps of primal_dual and of lemke on the same set', ''),
(13, 'ip-not-recommended', 1, 'The interior point method is nevertheless not recommended: it solves less than Lemke and takes longer.',
 'On every set: held-out best of Lemke less that of the interior point method above 0; mean time of the solved problems over all parameters, interior point over Lemke, above 1.',
 'sweeps of primal_dual and of lemke on the same set', ''),
(14, 'violation', 0, 'The constraint violation of PATH and Lemke is comparable on average.',
 'Solved by the criterion, over all parameters: mean violation of PATH over Lemke''s lies between 1/100 and 100 (the paper''s own lie between 1/30 and 3). The paper adds that in the worst case Lemke''s is better on monotone problems and worse on copositive ones: that is shown and not tested, a largest violation has no interval.',
 'sweeps of path and of lemke on the same set; PATH is installed by its users', ''),
(15, 'ceilings', 0, 'Raising the ceilings of coordinates and contacts from 15 and 20 to 100 has a limited effect.',
 'Held-out best of exp5-1e10 less that of extra100, both of condition 1e10, is below 10 points (the paper''s, copositive Lemke, is 8).',
 'one sweep on exp5-1e10 and extra100', ''),
(16, 'splitting', 1, 'Splitting (iterative) methods cannot be recommended: they solve less than half of the problems.',
 'Share solved by every parameterisation of psor, bullet_pgs and siconos_pgs, as far as they were run, below 50 % on every set.',
 'psor, bullet_pgs or siconos_pgs on a set of the paper', '')),

-- The sweeps that take part, by what is solved; shares as terms.
whole AS (SELECT * FROM paper_rates WHERE refused = ''),
rates AS (
  SELECT *, kind || ' ' || experiment AS place, reading || ', ' || solved_by AS scope, '`' || solver || '`' AS code,
         "average.share" || ' ' || "average.of" AS average, "held_out.share" || ' ' || "held_out.of" AS held_out,
         "worst_held_out.share" || ' ' || "worst_held_out.of" AS worst_held_out,
         "false_claims.share" || ' ' || "false_claims.of" AS false_claims,
         "unsolvable.share" || ' ' || "unsolvable.of" AS unsolvable, "solved_odd.share" || ' ' || "solved_odd.of" AS odd
  FROM whole w
  WHERE other_readings = '' AND solved_by <> 'criterion_any'
    AND 2 * trials >= (SELECT MAX(trials) FROM whole each WHERE each."set" = w."set")),
means AS (
  SELECT "set", solver, quantity, "all.max" AS largest, "all.mean" || ' ' || "all.sigma" || ' ' ||
         "all.problems" AS mean FROM paper_measurements WHERE solved_by = 'criterion'),
-- One solver of the paper on two experiments; the second has the reading.
subjects AS (
  SELECT a.experiment AS a, b.experiment AS b, b.kind || ', ' || b.code AS words, b.kind, b.solver, b.solved_by,
         iif(b.redundancy = '', a.reading, b.reading) AS reading,
         iif(b.redundancy = '', a.reading, b.reading) || ', ' || b.solved_by AS scope, a.average AS a_average,
         b.average AS b_average, a.held_out AS a_held_out, b.held_out AS b_held_out, a.unsolvable AS a_unsolvable,
         b.unsolvable AS b_unsolvable
  FROM rates a JOIN rates b USING (kind, solver, solved_by)
  WHERE b.paper_solver IS NOT NULL AND (a.redundancy = '' OR b.redundancy = '' OR a.reading = b.reading)),
-- A regularised solver on Experiment 6 with what it wraps on Experiment 5: the same problems.
regularised AS (
  SELECT w.kind, w.reading, w.scope, w.solved_by, w."set" AS w_set, w.solver AS w_solver, o."set" AS o_set,
         o.solver AS o_solver, w.average AS w_average, o.average AS o_average, w.false_claims AS w_false,
         o.false_claims AS o_false,
         w.code || ' against ' || o.code || ', condition ' || substr(w.experiment, 6) AS words
  FROM rates w JOIN rates o USING (kind, reading, solved_by)
  WHERE w.experiment LIKE 'exp6-%' AND o.experiment = 'exp5' || substr(w.experiment, 5) AND w.paper_solver IS NOT NULL
    AND o.base = w.wrapped AND o.sweep = w.sweep AND (o.isa = '' OR (o.isa = w.isa AND o.build = w.build))),
-- Lemke's algorithm and another solver on one set; two native solvers only within one build, as in pairs.sql.
rivals AS (
  SELECT l.place, l.kind, l.scope, l.reading, l.solved_by, l."set", l.solver AS l_solver, r.solver AS r_solver,
         r.paper_solver AS rival, l.code AS l_code, r.code AS r_code, l.held_out AS l_held_out,
         r.held_out AS r_held_out, l.worst_held_out AS l_worst, r.worst_held_out AS r_worst, l.average AS l_average,
         r.average AS r_average, 100 * (l."held_out.share" - l."worst_held_out.share") AS l_range,
         100 * (r."held_out.share" - r."worst_held_out.share") AS r_range, 100 * l.sigma AS l_sigma,
         100 * r.sigma AS r_sigma
  FROM rates l JOIN rates r USING ("set", solved_by)
  WHERE l.paper_solver = 'Lemke' AND r.paper_solver IS NOT 'Lemke'
    AND (l.isa = '' OR r.isa = '' OR (l.isa = r.isa AND l.build = r.build))),
ratios AS (
  SELECT v.*, m.quantity, m.mean || ' ' || n.mean AS terms, m.largest / n.largest AS largest
  FROM rivals v JOIN means m ON m."set" = v."set" AND m.solver = v.r_solver
       JOIN means n ON n."set" = v."set" AND n.solver = v.l_solver AND n.quantity = m.quantity
  WHERE v.solved_by = 'criterion'),
paired AS (
  SELECT *, problems || ' ' || only_first || ' ' || only_second AS terms, printf(
    '%d problems in pairs, %d only the first, %d only the second; McNemar p = %.2g', problems, only_first, only_second,
    mcnemar(only_first, only_second)) AS detail
  FROM paper_pairs),

comparisons(claim, part, quantity, scope, form, terms, claimed, bound, upper_bound, detail) AS (
  SELECT 'monotone-easier', iif(m.paper_solver IS NULL, 'beyond', 'claim'),
         m.experiment || ', ' || m.code || ': average on monotone − copositive', m.scope, 'shares',
         '1 ' || m.average || ' -1 ' || c.average, 'above', 0, NULL, ''
  FROM rates m JOIN rates c USING (experiment, reading, solver, solved_by)
  WHERE m.kind = 'monotone' AND c.kind = 'copositive' AND m.experiment <> 'extra100'
  UNION ALL
  SELECT 'regularisation-gain', 'claim', kind || ': ' || words, scope, 'shares', '1 ' || w_average || ' -1 ' ||
         o_average, 'above', 0, NULL, '' FROM regularised
  UNION ALL
  SELECT 'regularisation-gain', 'claim', kind || ', single settings: `' || solver || '` against `' || second ||
         '`, condition ' || substr(experiment, 6), reading || ', verdict', 'pairs', terms, 'above', 0, NULL, detail
  FROM paired WHERE experiment LIKE 'exp6-%' AND solver <> 'lemke'
  UNION ALL
  SELECT 'regularisation-closes-gap', 'claim', '2/3 of the advantage without − the advantage with: ' || m.words,
         m.scope, 'shares', (2.0 / 3) || ' ' || m.o_average || ' ' || (-2.0 / 3) || ' ' || c.o_average || ' -1 ' ||
         m.w_average || ' 1 ' || c.w_average, 'above', 0, NULL, ''
  FROM regularised m JOIN regularised c USING (words, reading, solved_by)
  WHERE m.kind = 'monotone' AND c.kind = 'copositive'
  UNION ALL
  SELECT 'regularisation-cost', 'claim', kind || ': ' || words, reading, 'means', m.mean || ' ' || n.mean, 'above',
         1.05, NULL, ''
  FROM regularised r JOIN means m ON m."set" = w_set AND m.solver = w_solver AND m.quantity = 'time_all'
       JOIN means n ON n."set" = o_set AND n.solver = o_solver AND n.quantity = 'time_all'
  WHERE r.solved_by = 'criterion'
  UNION ALL
  SELECT 'regularisation-false-claims', 'claim', kind || ': ' || words, scope, 'shares',
         '1 ' || w_false || ' -1 ' || o_false, 'below', 0.01, NULL, '' FROM regularised WHERE solved_by = 'verdict'
  UNION ALL
  SELECT 'redundancy-a-little', 'claim', words || ': Experiment 1 − 2', scope, 'shares',
         '1 ' || a_average || ' -1 ' || b_average, 'between', 0, 0.1, ''
  FROM subjects WHERE a = 'exp1' AND b = 'exp2'
  UNION ALL
  SELECT 'rank-far-more', 'claim', s.words || ': drop from Experiment 1 to 3 − twice that from 1 to 2', s.scope,
         'shares', '-1 ' || s.a_average || ' -1 ' || three.average || ' 2 ' || s.b_average, 'above', 0, NULL, ''
  FROM subjects s JOIN rates three USING (kind, solver, solved_by)
  WHERE s.a = 'exp1' AND s.b = 'exp2' AND three.experiment = 'exp3' AND solved_by = 'criterion'
  UNION ALL
  SELECT claim, 'explanation', printf('monotone Experiment %s, %s: share solved at the best parameters ' ||
         '(theory: %.2f %% can be solved)', substr(experiment, 4), code, 100 * solvable), scope, 'shares', '1 ' || odd,
         'between', solvable - 0.02, solvable + 0.02, ''
  FROM rates JOIN (SELECT 'rank-far-more' AS claim UNION ALL SELECT 'exp4-above-exp3')
  WHERE solvable IS NOT NULL AND paper_solver = 'Lemke' AND solved_by = 'verdict' AND CASE claim
    WHEN 'rank-far-more' THEN experiment = 'exp3'
    ELSE solver IN (SELECT solver FROM subjects WHERE kind = 'monotone' AND a = 'exp3' AND b = 'exp4') END
  UNION ALL
  SELECT 'exp4-above-exp3', iif(solved_by = 'criterion', 'claim', 'beyond'), words || ': average, Experiment 4 − 3',
         scope, 'shares', '1 ' || b_average || ' -1 ' || a_average, 'above', 0, NULL, ''
  FROM subjects WHERE a = 'exp3' AND b = 'exp4'
  UNION ALL
  SELECT 'exp4-above-exp3', iif(solved_by = 'criterion', 'claim', 'beyond'), words ||
         ': best held out, Experiment 4 − 3', scope, 'shares', '1 ' || b_held_out || ' -1 ' || a_held_out,
         'above', 0, NULL, '' FROM subjects WHERE a = 'exp3' AND b = 'exp4'
  UNION ALL
  SELECT 'exp4-above-exp3', 'beyond', kind || ': share proven unsolvable in this store, Experiment 3 − 4', reading,
         'shares', '1 ' || a_unsolvable || ' -1 ' || b_unsolvable, 'above', 0, NULL, ''
  FROM subjects WHERE a = 'exp3' AND b = 'exp4' AND solved_by = 'verdict'
  UNION ALL
  SELECT 'ceilings', 'claim', words || ': exp5-1e10 − extra100', scope, 'shares', '1 ' || a_held_out || ' -1 ' ||
         b_held_out, 'below', 0.1, NULL, '' FROM subjects WHERE a = 'exp5-1e10' AND b = 'extra100'
  UNION ALL
  SELECT 'lemke-best', iif(rival IS NULL, 'beyond', 'claim'), place || ': best held out, ' || l_code || ' − ' ||
         r_code, scope, 'shares', '1 ' || l_held_out || ' -1 ' || r_held_out, 'above', 0, NULL, '' FROM rivals
  UNION ALL
  SELECT 'lemke-best', 'claim', kind || ' ' || experiment || ': single settings, `lemke` − `' || second || '`',
         reading || ', verdict', 'pairs', terms, 'above', 0, NULL, detail FROM paired WHERE solver = 'lemke'
  UNION ALL
  SELECT 'path-wider', 'claim', place || ', ' || r_code || ' against ' || l_code || ': average', scope, 'shares',
         '1 ' || r_average || ' -1 ' || l_average, 'above', 0, NULL, '' FROM rivals WHERE rival = 'PATH'
  UNION ALL
  SELECT 'path-wider', 'claim', place || ', ' || r_code || ' against ' || l_code || ': worst held out', scope, 'shares',
         '1 ' || r_worst || ' -1 ' || l_worst, 'above', 0, NULL, '' FROM rivals WHERE rival = 'PATH'
  UNION ALL
  SELECT 'path-wider', 'claim', place || ', ' || r_code || ' against ' || l_code ||
         iif(quantity = 'violation', ': mean violation', ': mean time'), scope, 'means', terms, 'below', 1, NULL, ''
  FROM ratios WHERE rival = 'PATH' AND quantity <> 'time_all'
  UNION ALL
  SELECT 'lemke-path-speed', 'claim', place || ': ' || r_code || ' / ' || l_code, scope, 'means', terms,
         iif(kind = 'monotone', 'above', 'below'), iif(kind = 'monotone', 2, 0.5), NULL, ''
  FROM ratios WHERE rival = 'PATH' AND quantity = 'time_solved'
  UNION ALL
  SELECT 'violation', 'claim', place || ', ' || r_code || ' / ' || l_code || ': mean', scope, 'means', terms, 'between',
         0.01, 100, '' FROM ratios WHERE rival = 'PATH' AND quantity = 'violation'
  UNION ALL
  SELECT 'violation', 'beyond', place || ', ' || r_code || ' / ' || l_code || ': largest', scope, 'number', largest,
         iif(kind = 'monotone', 'above', 'below'), 1, NULL, 'no estimate: it has no interval, and is not tested'
  FROM ratios WHERE rival = 'PATH' AND quantity = 'violation'
  UNION ALL
  SELECT 'ip-robust', 'claim', place || ': range of ' || l_code || ' / 4 − range of ' || r_code, scope, 'shares',
         '0.25 ' || l_held_out || ' -0.25 ' || l_worst || ' -1 ' || r_held_out || ' 1 ' || r_worst, 'above', 0, NULL,
         printf('held-out ranges %.2f and %.2f points; standard deviations %.2f and %.2f', l_range, r_range, l_sigma,
         r_sigma) FROM rivals WHERE rival = 'IP'
  UNION ALL
  SELECT 'ip-not-recommended', 'claim', place || ', ' || l_code || ' and ' || r_code || ': share solved', scope,
         'shares', '1 ' || l_held_out || ' -1 ' || r_held_out, 'above', 0, NULL, '' FROM rivals WHERE rival = 'IP'
  UNION ALL
  SELECT 'ip-not-recommended', 'claim', place || ', ' || l_code || ' and ' || r_code || ': time', scope, 'means', terms,
         'above', 1, NULL, '' FROM ratios WHERE rival = 'IP' AND quantity = 'time_solved'
  UNION ALL
  SELECT 'splitting', 'claim', kind || ' ' || experiment || ', `' || spec || '`', reading || ', ' || solved_by,
         'shares', '1 ' || (1.0 * part / "of") || ' ' || "of", 'below', 0.5, NULL, ''
  FROM paper_cells JOIN paper_counts USING (place)
  WHERE name IN ('psor', 'bullet_pgs', 'siconos_pgs') AND refused = 0 AND other_readings = ''
    AND solved_by <> 'criterion_any'),

-- Within each part of a claim, m comparisons that have an interval are made at the level 5 %/m (Bonferroni), so that a
-- stance is due to chance in at most 5 % of studies. What has no number (a share of no odd trial) is not compared.
tested AS (
  SELECT *, 0.05 / MAX(1, SUM(form <> 'number') OVER (PARTITION BY claim, part)) AS level
  FROM (SELECT *, estimate(form, terms) AS value FROM comparisons) WHERE value IS NOT NULL),
ends AS (
  SELECT *, estimate_low(form, terms, 0.05) AS low, estimate_high(form, terms, 0.05) AS high,
         estimate_low(form, terms, level) AS least, estimate_high(form, terms, level) AS most,
         estimate_p(form, terms) AS p
  FROM tested),
stances AS (
  SELECT *, CASE WHEN form = 'number' THEN 'not tested' WHEN p > level THEN 'undecided'
    WHEN claimed = 'between' AND (most < bound OR least > upper_bound) THEN 'opposes'
    WHEN claimed = 'between' AND least > bound AND most < upper_bound THEN 'supports'
    WHEN claimed = 'between' THEN 'undecided'
    WHEN least > bound THEN iif(claimed = 'above', 'supports', 'opposes')
    WHEN most < bound THEN iif(claimed = 'above', 'opposes', 'supports') ELSE 'undecided' END AS stance
  FROM ends),
counts AS (
  SELECT claim, SUM(part = 'claim' AND stance = 'supports') AS supporting,
         SUM(part = 'claim' AND stance = 'opposes') AS opposing,
         SUM(part = 'claim' AND stance = 'undecided') AS undecided, SUM(part = 'explanation') AS causes,
         SUM(part = 'explanation' AND stance = 'supports') AS explaining
  FROM stances GROUP BY claim),
-- Confirmed: some comparisons support it, none opposes; of a claim on every set all do. Explained: confirmed, and all
-- comparisons that name the cause support the cause.
words AS (
  SELECT claims.*, CASE WHEN supporting + opposing + undecided > 0 THEN CASE
    WHEN opposing > 0 THEN iif(supporting > 0, 'confirmed in part', 'contradicted')
    WHEN supporting = 0 THEN 'undecided'
    WHEN every AND undecided > 0 THEN iif(supporting >= undecided, 'confirmed in part', 'undecided')
    WHEN causes > 0 AND explaining = causes THEN 'explained' ELSE 'confirmed' END ELSE 'not tested' END AS word
  FROM claims LEFT JOIN counts USING (claim))
SELECT claim, statement, test, needs, cause, word, coalesce(part, 'claim') AS part,
       coalesce(quantity, 'needs ' || needs) AS quantity, coalesce(scope, '') AS scope, value, low, high,
       coalesce(claimed, '') AS claimed, bound, upper_bound, coalesce(stance, '') AS stance,
       coalesce(detail, '') AS detail FROM words LEFT JOIN stances USING (claim)
WHERE EXISTS (SELECT 1 FROM paper_rates) ORDER BY place,
         CASE part WHEN 'claim' THEN 1 WHEN 'explanation' THEN 2 ELSE 3 END;
