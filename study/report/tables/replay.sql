-- Replays of scenes with each solver's answers
-- One row for each scene and solver.
SELECT * FROM replay
