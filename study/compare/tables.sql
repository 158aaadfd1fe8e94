-- Every parameterisation of either store; `kin` is the same where two may belong together.
CREATE TABLE cells (side TEXT, kin TEXT, solver TEXT, settings TEXT, library TEXT, version TEXT, isa TEXT, sweep TEXT,
                    name TEXT AS (solver || iif(settings = '', '', '{' || settings || '}') ||
                                  iif(sweep = '', '', ' (sweep ' || sweep || ')')));
CREATE TABLE matched (a INTEGER, b INTEGER);  -- rows of `cells`
-- The answers of both stores to the set at hand.
CREATE TABLE here (name TEXT);
CREATE TABLE answers (cell INTEGER, problem INTEGER, hash TEXT, solved INTEGER, wrong INTEGER, pivots INTEGER,
                      time_s REAL, PRIMARY KEY (cell, problem)) WITHOUT ROWID;
CREATE TABLE unmet (side TEXT, "set" TEXT, cell INTEGER);
CREATE TABLE changes ("set", a, b, problems, other_data, only_in_a, only_in_b, solved_a, solved_b, lost, gained,
                      false_a, false_b, false_gone, false_new, timed, logs, log_squares, faster, slower, median_ratio,
                      counted, pivots_a, pivots_b);
