#pragma once

namespace lcpbench {

/// The store: one SQLite file. Ids are 63-bit hashes of what they identify (set name; solver name, settings, library,
/// version, instruction-set level and sweep; set, seed and trial; vector content), so that stores written apart merge
/// by INSERT OR IGNORE and equal runs hold equal rows but for `timings` and `runs`.
///
/// Verdicts need every answer to a problem (one solver's solution proves solvable what another missed), so `verdicts`
/// holds what one answer shows by itself; the view `judged` adds the problem's truth and gives claim and verdict side
/// by side. Nothing of it needs a solver to run again: `vectors` keeps every answer exactly.
inline constexpr const char* kStoreSchema = R"sql(
CREATE TABLE IF NOT EXISTS runs (
  id INTEGER PRIMARY KEY, started TEXT NOT NULL, provenance TEXT NOT NULL);  -- JSON
CREATE TABLE IF NOT EXISTS sets (
  id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE);                         -- canonical, with its options
CREATE TABLE IF NOT EXISTS solvers (
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  settings TEXT NOT NULL,       -- those off their defaults, "key=value,key=value"
  all_settings TEXT NOT NULL,   -- every one, spelled out
  library TEXT NOT NULL,        -- "native" or the library's name
  version TEXT NOT NULL,
  isa TEXT NOT NULL,            -- instruction-set level of native code, "" for libraries
  sweep TEXT NOT NULL);         -- "" or the sweep this parameterisation belongs to: "paper", "paper{engine=kernel}"
CREATE TABLE IF NOT EXISTS problems (
  id INTEGER PRIMARY KEY,
  set_id INTEGER NOT NULL REFERENCES sets(id),
  seed INTEGER NOT NULL,
  trial INTEGER NOT NULL,
  kind TEXT NOT NULL,           -- "lcp", "contact", "scene"
  n INTEGER NOT NULL,
  ngc INTEGER NOT NULL,
  nc INTEGER NOT NULL,
  hash TEXT NOT NULL,           -- of the problem's data, hexadecimal
  theory TEXT NOT NULL,         -- "solvable" when proven from the data alone, else ""
  UNIQUE (set_id, seed, trial));
CREATE TABLE IF NOT EXISTS vectors (
  id INTEGER PRIMARY KEY, data BLOB NOT NULL);                                -- see study/vector_codec.h
CREATE TABLE IF NOT EXISTS answers (
  problem_id INTEGER NOT NULL REFERENCES problems(id),
  solver_id INTEGER NOT NULL REFERENCES solvers(id),
  claim TEXT NOT NULL,
  z INTEGER REFERENCES vectors(id),
  velocity INTEGER REFERENCES vectors(id),
  farkas INTEGER REFERENCES vectors(id),
  iterations INTEGER NOT NULL,
  pivots INTEGER NOT NULL,
  factorizations INTEGER NOT NULL,
  detail TEXT NOT NULL,
  PRIMARY KEY (problem_id, solver_id)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS verdicts (
  problem_id INTEGER NOT NULL,
  solver_id INTEGER NOT NULL,
  usable INTEGER NOT NULL,
  solved INTEGER NOT NULL,
  criterion INTEGER NOT NULL,
  farkas_checked INTEGER NOT NULL,  -- 1 when the answer's proof of unsolvability was checked and holds
  velocity_residual_m_per_s REAL, velocity_residual_relative REAL, natural_residual REAL,
  backward_componentwise REAL, backward_row_norm REAL, forward_velocity REAL,
  violation_m_per_s REAL, work_gain_j REAL, complementarity_j REAL, cone_violation REAL, min_z REAL,
  PRIMARY KEY (problem_id, solver_id)) WITHOUT ROWID;
CREATE INDEX IF NOT EXISTS checked_proofs ON verdicts(problem_id) WHERE farkas_checked = 1;
CREATE TABLE IF NOT EXISTS timings (
  problem_id INTEGER NOT NULL,
  solver_id INTEGER NOT NULL,
  run_id INTEGER NOT NULL,
  setup_wall_s REAL NOT NULL, setup_cpu_s REAL NOT NULL,
  solve_wall_s REAL NOT NULL, solve_cpu_s REAL NOT NULL,
  transport_s REAL NOT NULL, verify_s REAL NOT NULL,
  repeats INTEGER NOT NULL,
  PRIMARY KEY (problem_id, solver_id)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS certificates (
  problem_id INTEGER PRIMARY KEY,
  certificate TEXT NOT NULL,    -- "solution" or "unsolvable"
  proof TEXT NOT NULL,
  vector INTEGER REFERENCES vectors(id));

CREATE VIEW IF NOT EXISTS truths AS
  SELECT p.id AS problem_id,
         CASE WHEN EXISTS (SELECT 1 FROM certificates c WHERE c.problem_id = p.id AND c.certificate = 'unsolvable')
                OR EXISTS (SELECT 1 FROM verdicts v WHERE v.problem_id = p.id AND v.farkas_checked = 1) THEN 'unsolvable'
              WHEN p.theory = 'solvable'
                OR EXISTS (SELECT 1 FROM certificates c WHERE c.problem_id = p.id AND c.certificate = 'solution')
                OR EXISTS (SELECT 1 FROM verdicts v WHERE v.problem_id = p.id AND v.solved = 1) THEN 'solvable'
              ELSE 'unknown' END AS truth
  FROM problems p;
CREATE VIEW IF NOT EXISTS judged AS
  SELECT a.problem_id, a.solver_id, p.set_id, p.seed, p.trial, p.n, a.claim, t.truth,
         CASE WHEN t.truth = 'unsolvable' THEN 'unsolvable'
              WHEN v.solved = 1 THEN 'solved'
              WHEN v.criterion = 1 THEN 'criterion_only'
              WHEN a.claim = 'solved' THEN 'wrong'
              WHEN t.truth = 'solvable' THEN 'missed'
              ELSE 'open' END AS verdict
  FROM answers a JOIN verdicts v USING (problem_id, solver_id)
  JOIN problems p ON p.id = a.problem_id JOIN truths t ON t.problem_id = a.problem_id;
)sql";

}  // namespace lcpbench
