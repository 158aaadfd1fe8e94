-- The comparisons behind the paper's claims
-- Each with its 95 % interval and its bound.
-- only in tables/
SELECT claim, word, part, quantity, scope, value, low, high, claimed, bound, upper_bound, stance, detail
FROM paper_claims
