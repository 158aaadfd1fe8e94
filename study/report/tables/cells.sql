-- All numbers of every set and solver
-- The cells of summary.json, those of sweeps too, with a dot between nested names.
-- only in tables/
SELECT * FROM cells
