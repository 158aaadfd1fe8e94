-- Hard cases
-- What became of each case with each solver; truth is what the case's formula says of it, on which no verdict depends.
SELECT * FROM hard_cases
