#include "study/store/schema.h"

#include <string_view>

#include <fmt/format.h>

#include "study/evaluation/evaluation.h"

namespace lcpbench {
namespace {

// A store is opened only if it was made by these statements; comments and white space may differ.
constexpr std::string_view kSchema = R"sql(
CREATE TABLE IF NOT EXISTS runs (
  id INTEGER PRIMARY KEY, started TEXT NOT NULL, provenance TEXT NOT NULL,    -- JSON
  checksum INTEGER NOT NULL) STRICT;
CREATE TABLE IF NOT EXISTS sets (
  id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE,                          -- canonical, with its options
  checksum INTEGER NOT NULL) STRICT;
CREATE TABLE IF NOT EXISTS solvers (
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  settings TEXT NOT NULL,       -- those off their defaults, "key=value,key=value"; of a sweep: those that all cells share
  all_settings TEXT NOT NULL,   -- every one, spelled out
  library TEXT NOT NULL,        -- "native" or the library's name
  version TEXT NOT NULL,
  isa TEXT NOT NULL,            -- instruction-set level of native code, "" for libraries
  sweep TEXT NOT NULL,          -- "" or the name of a sweep with the shared settings: "paper", "paper{engine=kernel}"
  cells INTEGER NOT NULL,       -- number of parameterisations: 1 unless it is a sweep
  checksum INTEGER NOT NULL) STRICT;
CREATE TABLE IF NOT EXISTS parameterisations (
  solver_id INTEGER NOT NULL REFERENCES solvers(id),
  cell INTEGER NOT NULL,        -- 0, 1, ...: the grid's order, its first axis varies slowest
  settings TEXT NOT NULL,       -- those off their defaults
  all_settings TEXT NOT NULL,
  friction TEXT NOT NULL,       -- that it solves: "pyramid", "cone" or "convex"
  checksum INTEGER NOT NULL,
  PRIMARY KEY (solver_id, cell)) WITHOUT ROWID, STRICT;
CREATE TABLE IF NOT EXISTS problems (
  id INTEGER PRIMARY KEY,
  set_id INTEGER NOT NULL REFERENCES sets(id),
  seed INTEGER NOT NULL,
  trial INTEGER NOT NULL,
  kind TEXT NOT NULL,           -- "lcp", "contact", "scene"
  n INTEGER NOT NULL,
  ngc INTEGER NOT NULL,
  nc INTEGER NOT NULL,
  free_bodies INTEGER NOT NULL,  -- 1: the inertia is that of free bodies, or diagonal; else 0
  hash TEXT NOT NULL,           -- of the problem's data, hexadecimal
  theory TEXT NOT NULL,         -- "solvable" when proven from the data alone, else ""
  notes TEXT NOT NULL,          -- JSON: how a captured problem differs from the engine's step, each "what: how many"
  checksum INTEGER NOT NULL,
  UNIQUE (set_id, seed, trial)) STRICT;
CREATE TABLE IF NOT EXISTS vectors (
  id INTEGER PRIMARY KEY, data BLOB NOT NULL) STRICT;                         -- see study/store/vector_codec.h
CREATE TABLE IF NOT EXISTS cell_groups (
  group_id INTEGER NOT NULL,    -- hash of the group's cells
  cell INTEGER NOT NULL,
  PRIMARY KEY (group_id, cell)) WITHOUT ROWID, STRICT;
CREATE TABLE IF NOT EXISTS answers (
  problem_id INTEGER NOT NULL REFERENCES problems(id),
  solver_id INTEGER NOT NULL REFERENCES solvers(id),
  part INTEGER NOT NULL,        -- lowest cell that gave this answer; every solver that ran has a part 0
  group_id INTEGER NOT NULL,    -- all cells that gave it
  claim TEXT NOT NULL,
  z INTEGER REFERENCES vectors(id),
  velocity INTEGER REFERENCES vectors(id),
  farkas INTEGER REFERENCES vectors(id),
  iterations INTEGER NOT NULL,
  pivots INTEGER NOT NULL,
  factorizations INTEGER NOT NULL,
  detail TEXT NOT NULL,
  checksum INTEGER NOT NULL,
  PRIMARY KEY (problem_id, solver_id, part),
  FOREIGN KEY (group_id, part) REFERENCES cell_groups) WITHOUT ROWID, STRICT;
CREATE TABLE IF NOT EXISTS verdicts (
  problem_id INTEGER NOT NULL,
  solver_id INTEGER NOT NULL,
  part INTEGER NOT NULL,
  usable INTEGER NOT NULL,
  solved INTEGER NOT NULL,
  criterion INTEGER NOT NULL,
  farkas_checked INTEGER NOT NULL,  -- 1 when the answer's proof of unsolvability was checked and holds
  worst_row INTEGER,                -- LCP row of the largest rho (bare LCP: backward error); NULL where that is 0,
                                    -- or z not usable; -1: the inertia is unresolved, and nothing is measured
@metrics@
  checksum INTEGER NOT NULL,
  PRIMARY KEY (problem_id, solver_id, part),
  FOREIGN KEY (problem_id, solver_id, part) REFERENCES answers) WITHOUT ROWID, STRICT;
CREATE INDEX IF NOT EXISTS checked_proofs ON verdicts(problem_id) WHERE farkas_checked = 1;
CREATE TABLE IF NOT EXISTS timings (
  problem_id INTEGER NOT NULL,
  solver_id INTEGER NOT NULL,
  part INTEGER NOT NULL,
  run_id INTEGER NOT NULL REFERENCES runs(id),
  setup_wall_s REAL NOT NULL, setup_cpu_s REAL NOT NULL,
  solve_wall_s REAL NOT NULL, solve_cpu_s REAL NOT NULL,
  transport_s REAL NOT NULL, verify_s REAL NOT NULL,
  repeats INTEGER NOT NULL,
  checksum INTEGER NOT NULL,
  PRIMARY KEY (problem_id, solver_id, part),
  FOREIGN KEY (problem_id, solver_id, part) REFERENCES answers) WITHOUT ROWID, STRICT;
CREATE TABLE IF NOT EXISTS certificates (
  problem_id INTEGER PRIMARY KEY REFERENCES problems(id),
  certificate TEXT NOT NULL,    -- "solution", "unsolvable", "open": see docs/explanation/certificates.md
  proof TEXT NOT NULL,          -- "exact_basis", "farkas", "every_basis", "lp"; "none" where open
  velocity INTEGER REFERENCES vectors(id),  -- v+ of the certified solution, each entry correctly rounded
  velocity_unique INTEGER,      -- 1: every solution has this v+; 0: some solution has another; NULL: not known
  least_violation_m_per_s REAL, -- contacts, by "farkas": any impulses violate one by at least this; else NULL
  proof_margin REAL,            -- bare LCPs, by "farkas": by so much it misses a solution; else NULL
  detail TEXT NOT NULL,
  checksum INTEGER NOT NULL) STRICT;
CREATE TABLE IF NOT EXISTS proofs (
  problem_id INTEGER PRIMARY KEY REFERENCES certificates(problem_id),
  document BLOB NOT NULL,       -- problem and exact proof, what study/check_certificates.py reads: JSON, deflated
  checksum INTEGER NOT NULL) STRICT;
CREATE TABLE IF NOT EXISTS certificate_timings (
  problem_id INTEGER PRIMARY KEY REFERENCES certificates(problem_id),
  seconds REAL NOT NULL,        -- wall clock
  time_limit_s REAL NOT NULL,
  checksum INTEGER NOT NULL) STRICT;
CREATE TABLE IF NOT EXISTS totals (   -- one row for each table above, see study/store/totals.h
  name TEXT PRIMARY KEY, row_count INTEGER NOT NULL, digest INTEGER NOT NULL) WITHOUT ROWID, STRICT;
CREATE TABLE IF NOT EXISTS writing (  -- one row while a writer has the store open
  id INTEGER PRIMARY KEY CHECK (id = 1), since TEXT NOT NULL) STRICT;

CREATE VIEW IF NOT EXISTS truths AS
  SELECT problem_id, iif(state = 'answered', 'unknown', state) AS truth, state FROM (
  SELECT p.id AS problem_id,
         @truth@ AS state  -- also 'answered': nothing is proven, and some answer passes
  FROM problems p);
CREATE VIEW IF NOT EXISTS judged AS
  SELECT a.problem_id, a.solver_id, a.part, a.group_id,
         (SELECT COUNT(*) FROM cell_groups g WHERE g.group_id = a.group_id) AS cells,
         p.set_id, p.seed, p.trial, p.n, a.claim,
         @truth of the answer@ AS truth,
         @verdict@ AS verdict,
         @model@ AS model  -- that the answer was measured by
  FROM answers a JOIN verdicts v USING (problem_id, solver_id, part)
  LEFT JOIN parameterisations c ON c.solver_id = a.solver_id AND c.cell = a.part
  JOIN problems p ON p.id = a.problem_id JOIN truths t ON t.problem_id = a.problem_id;
CREATE VIEW IF NOT EXISTS judged_cells AS
  SELECT j.problem_id, j.solver_id, g.cell, j.part, c.settings,
         j.set_id, j.seed, j.trial, j.n, j.claim, j.truth, j.verdict, j.model
  FROM judged j JOIN cell_groups g ON g.group_id = j.group_id
  JOIN parameterisations c ON c.solver_id = j.solver_id AND c.cell = g.cell;
)sql";

/// The names of the stored metrics, each followed by `suffix`, with `separator` between them.
std::string metrics(std::string_view suffix, std::string_view separator) {
  std::string text;
  for (const Metric& metric : kMetrics) {
    if (metric.stored) text += fmt::format("{}{}{}", text.empty() ? "" : separator, metric.name, suffix);
  }
  return text;
}

/// The friction model by which answers of a row c of `parameterisations` to a row p of `problems` are measured.
constexpr std::string_view kModel =
    "CASE WHEN p.nc > 0 AND p.n > p.nc THEN coalesce(c.friction, 'pyramid') ELSE 'pyramid' END";

/// The truth by which an answer is judged: that of the problem, a column of `truths`, is known for the pyramid alone.
std::string truth_of_answer(std::string_view column) {
  return fmt::format("iif({} = 'pyramid', t.{}, '{}')", kModel, column, to_string(Truth::kUnknown));
}

/// As in the column `state`.
const char* state_of(Truth truth) { return truth == Truth::kAnswered ? "answered" : to_string(truth); }

/// Whether there is this evidence about the problem of a row p of `problems`.
std::string condition_of(Evidence evidence) {
  const auto proof_by_margin = [](std::string_view comparison) {
    return fmt::format(
        "(EXISTS (SELECT 1 FROM certificates c WHERE c.problem_id = p.id AND c.certificate = 'unsolvable' AND "
        "c.proof_margin {0} {1}) OR EXISTS (SELECT 1 FROM verdicts v WHERE v.problem_id = p.id AND v.farkas_checked = 1 "
        "AND v.proof_margin {0} {1}))",
        comparison, kSolvedBackwardError);
  };
  switch (evidence) {
    case Evidence::kClearProof: return proof_by_margin(">");
    case Evidence::kCloseProof: return proof_by_margin("<=");
    case Evidence::kCertifiedUnsolvable:
      return "EXISTS (SELECT 1 FROM certificates c WHERE c.problem_id = p.id AND c.certificate = 'unsolvable')";
    case Evidence::kValidProof:
      return "EXISTS (SELECT 1 FROM verdicts v WHERE v.problem_id = p.id AND v.farkas_checked = 1)";
    case Evidence::kTheory: return "p.theory = 'solvable'";
    case Evidence::kCertifiedSolution:
      return "EXISTS (SELECT 1 FROM certificates c WHERE c.problem_id = p.id AND c.certificate = 'solution')";
    case Evidence::kSolvedAnswer:
      return fmt::format(
          "EXISTS (SELECT 1 FROM verdicts v LEFT JOIN parameterisations c ON c.solver_id = v.solver_id AND c.cell = "
          "v.part "
          "WHERE v.problem_id = p.id AND v.solved = 1 AND {} = 'pyramid')",
          kModel);
  }
  return "";
}

/// kTruthRules as an SQL expression; consecutive rules with the same truth share one WHEN.
std::string truth_case() {
  std::string text = "CASE";
  for (std::size_t i = 0; i < kTruthRules.size(); ++i) {
    const auto& [evidence, truth, also] = kTruthRules[i];
    const bool shares = i > 0 && kTruthRules[i - 1].truth == truth;
    text += fmt::format("{}{}", shares ? "\n                OR " : " WHEN ", condition_of(evidence));
    if (also) text += " AND " + condition_of(*also);
    if (i + 1 == kTruthRules.size() || kTruthRules[i + 1].truth != truth) {
      text += fmt::format(" THEN '{}'\n             ", state_of(truth));
    }
  }
  return text + fmt::format(" ELSE '{}' END", to_string(Truth::kUnknown));
}

/// kVerdictRules as an SQL expression.
std::string verdict_case() {
  std::string text = "CASE";
  for (const VerdictRule& rule : kVerdictRules) {
    std::string condition;
    const auto also = [&condition](const std::string& term) { condition += (condition.empty() ? "" : " AND ") + term; };
    if (rule.passes) also("v.solved = 1");
    if (rule.unresolved) also("v.worst_row = -1");
    if (rule.claim) also(fmt::format("a.claim = '{}'", to_string(*rule.claim)));
    if (rule.truth) also(fmt::format("{} = '{}'", truth_of_answer("state"), state_of(*rule.truth)));
    if (rule.truth_is_not) also(fmt::format("{} <> '{}'", truth_of_answer("state"), state_of(*rule.truth_is_not)));
    text += condition.empty() ? fmt::format(" ELSE '{}' END", to_string(rule.verdict))
                              : fmt::format(" WHEN {} THEN '{}'\n             ", condition, to_string(rule.verdict));
  }
  return text;
}

}  // namespace

std::string store_schema() {
  std::string schema(kSchema);
  const auto fill_in = [&schema](std::string_view place, const std::string& text) {
    schema.replace(schema.find(place), place.size(), text);
  };
  fill_in("@metrics@", "  " + metrics(" REAL,", "\n  "));
  fill_in("@truth@", truth_case());
  fill_in("@truth of the answer@", truth_of_answer("truth"));
  fill_in("@verdict@", verdict_case());
  fill_in("@model@", std::string(kModel));
  return schema;
}

std::string metric_columns() { return metrics("", ", "); }

}  // namespace lcpbench
