#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/spec.h"
#include "study/summary/summary.h"

// What a store says of the hard cases, sets hard/<family>/<case>{dials}: one problem each, so that a table of solvers
// against cases says all there is.

namespace lcpbench::report {

/// What became of one case with one solver, from harmless to worst.
enum class HardOutcome {
  kNotRun,
  kRefused,            ///< outside what the solver takes
  kSolved,             ///< said solved, and is
  kRightlyUnsolvable,  ///< said to have no solution, and proven to have none
  kGaveUpUnsolvable,   ///< gave up on what has no solution
  kSolvedUnclaimed,    ///< the answer is right, the solver did not say so
  kUndecided,          ///< gave up, or said to have no solution, and nobody knows
  kMissed,             ///< gave up on what has a solution
  kWronglyUnsolvable,  ///< said to have no solution, has one
  kFalseClaim,         ///< said solved, and is not: wrong and silent
};

/// "solved", "missed", "false_claim", ...: the words of the tables. "" where it was not run.
const char* to_string(HardOutcome outcome);

/// Solved, or rightly found to have no solution.
bool is_right(HardOutcome outcome);

/// The worse of what the cell's trials came to; a hard set has one.
HardOutcome hard_outcome(const Cell& cell);

struct HardCaseCell {
  HardOutcome outcome = HardOutcome::kNotRun;
  const Cell* cell = nullptr;  ///< of the summary; none: not run
};

struct HardCaseRow {
  std::size_t set = 0;              ///< index into Summary::sets
  Spec spec;                        ///< of the set: its name and the dials off their defaults
  std::string truth;                ///< what the formula says of it; "" where this program does not know the set
  std::vector<HardCaseCell> cells;  ///< one for each of HardStudy::solvers
};

/// The cases that differ in one dial alone.
struct HardDial {
  std::string set;  ///< name without dials
  std::string dial;
  std::string help;
  std::vector<std::string> values;  ///< ascending; choices in their own order
  std::vector<std::size_t> rows;    ///< of HardStudy::rows, one for each value
};

/// Points into the summary that it was made from.
struct HardStudy {
  std::vector<std::size_t> solvers;  ///< indices into Summary::solvers that met a hard case, sweeps left out
  std::vector<HardCaseRow> rows;     ///< in the summary's order
  std::vector<HardDial> dials;       ///< those with more than one value in the store

  bool empty() const { return rows.empty(); }
};

/// Whether a set is one of the hard cases, by its name.
bool is_hard_set(std::string_view name);

/// Whether the store has problems, and all of them are hard cases.
bool has_only_hard_sets(const Summary& summary);

/// "contact" of hard/contact/stack{k=4}.
std::string hard_family(const std::string& name);

HardStudy hard_study(const Summary& summary);

/// Records for CSV tables, by table: `hard_matrix` (a case in each row, a solver in each column), `hard_cases` (one row
/// per case and solver), `hard_dials` (one per dial and solver: the values at which it was right and at which not, and
/// the worst of these).
nlohmann::ordered_json hard_tables(const Summary& summary, const HardStudy& study);

/// The hard cases as text, in lines of `width` characters: for each solver what became of them, and every false claim
/// by name. "" without any.
std::string hard_text(const Summary& summary, int width);

}  // namespace lcpbench::report
