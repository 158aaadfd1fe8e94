-- Claim against verdict
-- What each solver said, and how many of these answers the verdicts call solved, wrong and so on.
-- only in tables/
SELECT * FROM claims
