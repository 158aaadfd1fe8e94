-- The claims of the paper, tested
-- Each claim with its test, and how many of its comparisons support or oppose it, each at 5 % divided by their number.
SELECT claim, statement, test, word, SUM(part = 'claim' AND stance = 'supports') AS supports,
       SUM(part = 'claim' AND stance = 'opposes') AS opposes,
       SUM(part = 'claim' AND stance <> '') AS comparisons, iif(word = 'explained', cause, '') AS cause,
       iif(word = 'not tested', needs, '') AS needs
FROM paper_claims GROUP BY claim ORDER BY MIN(rowid)
