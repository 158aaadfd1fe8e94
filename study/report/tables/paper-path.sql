-- PATH 4.7.03, measured apart from any store
-- The library is its users' own: 2,000 trials of seed 1 over the paper's nine tolerances. Frictionless experiments, redundant contacts as multiples.
SELECT p.title AS experiment, p.quantity AS solved_by, r.worst AS published_worst, r.average AS published_average,
       r.best AS published_best, p.worst, p.average, p.best
FROM published p JOIN published r
  ON r.kind = p.kind AND r.experiment = p.experiment AND r.solver = p.solver AND r.quantity = 'rate'
WHERE p.quantity LIKE 'path%' AND EXISTS (SELECT 1 FROM paper_rates)
