-- Sweeps: worst, average and best parameterisation
-- Shares solved over the parameterisations that one set met; best_held_out is chosen on the even trials and counted on the odd ones.
SELECT * FROM sweeps
