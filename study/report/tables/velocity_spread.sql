-- Steps on which verified answers move differently
-- Captured steps with friction that two solvers solved, or more: the largest difference of a velocity at a contact between their answers, whose answers they are, and whether that is more than the verdict lets pass where the velocity is unique.
SELECT * FROM velocity_spread
