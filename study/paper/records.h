#pragma once

#include <string_view>

#include "study/output/json_output.h"
#include "study/summary/summary.h"

namespace lcpbench::paper {

/// study/paper/cells.sql, pairs.sql, rates.sql and claims.sql: make the temporary tables `published` (the file
/// published.csv: the figures of the paper's tables; of PATH 4.7.03 also what it did over the paper's nine tolerances
/// on 2,000 trials of seed 1, measured apart from any store, as path_criterion (answers claimed as solved) and
/// path_criterion_any; docs/explanation/paper-study.md says where they are from), `paper_cells` (every parameterisation
/// on a set of the paper), `paper_pairs` (solvers at single settings that are compared problem by problem),
/// `paper_rates` (each sweep on a set of the paper, by each way to count what is solved: worst, average and best over
/// its parameterisations), `paper_statistics` (a row for each of these shares), `paper_measurements` (its times and
/// violations) and `paper_claims` (the paper's claims with their comparisons) from the tables below and those of the
/// store, by the functions of study/report/sql_functions.h.
extern const std::string_view kQueries;

/// Records of temporary tables, of every parameterisation on a set whose name begins with "paper/": `paper_counts`
/// (what it solved, by each way to count) and `paper_spreads` (times and violations of those of sweeps). `place` is the
/// number of its cell, from 0 in the order of the table `cells`.
Json paper_records(const Summary& summary);

}  // namespace lcpbench::paper
