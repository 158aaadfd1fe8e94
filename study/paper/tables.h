#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "study/paper/grids.h"

namespace lcpbench::paper {

/// Text between backticks, which pages show as code; backticks and line ends inside are replaced.
std::string code(std::string text);

/// One entry of a table; `detail` is a second, smaller line. Both are plain text; `backticks` mark code.
struct Entry {
  std::string text;
  std::string detail;
};

/// A table as a page shows it.
struct Layout {
  std::string caption;
  std::vector<std::string> columns;
  std::size_t labels = 1;  ///< leading columns that name the row
  std::vector<std::vector<Entry>> rows;
};

/// A table with everything that goes with it.
struct Table {
  std::string id;  ///< "IV.1"; file names have it
  std::string title;
  std::vector<Layout> layouts;
  std::vector<std::string> notes;
  std::string query;               ///< SQL that repeats the table's counts on the store
  nlohmann::ordered_json example;  ///< a record with every column, for the heading of an empty CSV file
  nlohmann::ordered_json records;  ///< the same numbers, unrounded, one per row of the CSV file
};

/// IV.1 (monotone) or IV.2 (copositive): solution frequency, published beside both readings of redundancy by both
/// measures, with the parameterisation that the even trials choose.
Table rates_table(const Summary& summary, const std::vector<Grid>& grids, Kind kind);

/// IV.3 or IV.4: running times of Experiment 6, with the ratios between solvers that are compared.
Table times_table(const Summary& summary, const std::vector<Grid>& grids, Kind kind);

/// IV.5 or IV.6: normal constraint violation of the solved problems of Experiment 6.
Table violations_table(const Summary& summary, const std::vector<Grid>& grids, Kind kind);

/// Times and violations of every experiment, of which the paper prints Experiment 6 only: records without a layout.
Table measurements_table(const Summary& summary, const std::vector<Grid>& grids);

// Numbers of the paper's tables and what is compared with them.

/// "97.59"; 100 and 0 only when exactly that; "–" for NaN.
std::string points(double share);
/// "97.10–98.03"
std::string points(const Interval& interval);
/// "0.00014"; "–" for NaN.
std::string number(double value);
/// "1.40e-4 (0.001) 0.03": mean, sigma, maximum.
std::string spread_text(double mean, double sigma, double max);

/// NaN and infinities as null, so that equal data give equal files everywhere.
nlohmann::ordered_json number_json(double value);
nlohmann::ordered_json share_json(const Proportion& share);

}  // namespace lcpbench::paper
