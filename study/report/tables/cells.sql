-- All numbers of every set and solver
-- The cells of summary.json, those of sweeps too; names of nested members are joined by dots. Their claims are in the
-- table claims. Added: label, refusal and reliability.
-- only in tables/
SELECT * FROM cells
