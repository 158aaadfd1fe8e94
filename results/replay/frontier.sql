-- The rows of cost.csv that none is cheaper and better than:
-- sqlite3 :memory: '.import --csv cost.csv cost' '.mode csv' '.headers on' '.read frontier.sql'
WITH judged AS (
  SELECT iif(instr(scene, '{'), substr(scene, 1, instr(scene, '{') - 1), scene) AS scene,
         iif(stepper = 'engine', engine || ' as shipped', solver) ||
           iif(instr(scene, '{divide=1') OR NOT instr(scene, '{'), '',
             ' in h/' || substr(scene, -2, 1)) AS stepper, cast(cpu_s_per_s AS REAL) AS cpu_s_per_s,
         iif(cast(survived AS INT) < cast(steps AS INT), 0.1,
             cast(coalesce(nullif(slip_m, ''), nullif(drift_m, ''), deepest_m) AS REAL)) AS error_m
  FROM cost WHERE cpu_s_per_s <> '')
SELECT * FROM judged j
WHERE error_m < 0.1 AND NOT EXISTS (
  SELECT 1 FROM judged o WHERE o.scene = j.scene AND o.cpu_s_per_s < j.cpu_s_per_s
    AND o.error_m <= max(j.error_m, 1e-6))
ORDER BY scene, cpu_s_per_s
