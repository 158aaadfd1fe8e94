#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "study/replay/replay_folder.h"
#include "study/report/decision.h"
#include "study/report/regret.h"
#include "study/report/tables.h"
#include "study/report/worst.h"
#include "study/store/store.h"
#include "study/summary/summary.h"

namespace lcpbench {

namespace report {

/// How many of the worst problems of a solver on a set are named.
inline constexpr std::size_t kWorst = 3;

/// All that a report goes by. One scan of the answers gives it.
struct Report {
  Summary summary;  ///< without outcomes
  Statistics statistics;
  std::vector<std::vector<FailedProblem>> worst;  ///< by cell, at most kWorst, the worst first
  Regrets regrets;
  std::vector<Situation> situations;
};

/// Reads a store, which may be half filled; nothing is solved again. @throws InputError when it cannot be read.
Report read_report(Store& store);

/// The content of summary.json.
Json report_summary_json(const Report& report);

/// Fills the temporary tables that queries read, makes the views of study/report/views.sql over them, and gives the
/// store's connection the functions of sql_functions.h:
///
/// `cells` (one row per set and solver or parameterisation of a sweep: the cells of summary.json, with the solver's
/// label), `sweeps`, `claims` (claim against verdict), `set_facts`, `solver_facts`, `cell_statistics`,
/// `pair_statistics`, `situations` and `contenders` (who was compared for each of them at each error), `worst` (failed
/// problems with their commands), `rule` (one row: reliability_rule_json()), `errors` (kErrorGrid), `regrets`, and
/// those of study/paper/records.h. `named` has those of `named`, SolverRow::text() of solvers that the user named, by
/// their labels: the terminal's answer begins with them.
void fill_tables(Store& store, const Report& report, const std::vector<std::string>& named = {});

/// Two more: `replay`, and `model_errors`, which takes longer.
void fill_slow_tables(Store& store, const Summary& summary, const std::vector<ReplayedFiles>& replays = {});

/// The parts of report.json that are no tables, see docs/schema/report.schema.json. @pre the tables are filled
Json report_json(Store& store, const Report& report);

/// The rows of a query as a table for people; "no rows" where there are none.
std::string query_text(const QueryResult& result, int width);

}  // namespace report

/// Writes `report.html` (one file), `report.json`, `summary.json` and `tables/*.csv` into a folder, which is made where
/// it is missing; files of the same names are replaced, others are left alone. Nothing is solved again. Every row that
/// it reads is checked, but for those around the answers, see Checked.
/// @throws InputError when the store cannot be read or a file cannot be written.
Coverage write_report(Store& store, const std::filesystem::path& folder,
                      const std::vector<ReplayedFiles>& replays = {});

// What a store says, in text for the terminal.

/// The answer: for each kind of contacts the solver to use, the more accurate ones that cost more, the best of Bullet
/// and of ODE beside them with the factors in time, and at the end who said solved and was wrong. At most so many
/// lines, unless a sentence takes more. Serves half-filled stores.
/// @pre the tables are filled
std::string answer_text(Store& store, const report::Report& report, int width, std::size_t lines);

/// All results: for each set and solver the share solved and its 95 % interval, false claims, giving up, median time,
/// time ratio to the reference, and the 99th percentile of the error; sweeps as worst, average and best; then the hard
/// cases. Serves half-filled stores. @pre the tables are filled
std::string results_text(Store& store, const Summary& summary, int width);

/// Tables IV.1 to IV.6 of the paper, in its layout: published figures and those of the store, see
/// study/paper/rates.sql. Those that the store has no sweep for are left out; "" where it has none for any. @pre the
/// tables are filled
std::string paper_text(Store& store, int width);

/// For each solver that fails its worst problem, the gravest first: at most so many commands, with a line above them
/// and one that says how many were left out. "" where nobody fails, or without rows. @pre the tables are filled
std::string worst_text(Store& store, std::size_t rows, int width);

}  // namespace lcpbench
