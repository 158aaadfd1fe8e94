#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "study/paper/grids.h"
#include "study/paper/published.h"

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

/// IV.1 (monotone) or IV.2 (copositive): solution frequency, published beside both readings of redundancy by all
/// three counts, with the parameterisation that the even trials choose.
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

nlohmann::ordered_json share_json(const Proportion& share);

// What the tables of shares and those of times and violations have in common.

/// Stands where there is no number.
inline constexpr const char* kAbsent = "–";

inline constexpr const char* kSolvedNote =
    "Solved by the paper’s criterion: normal violation below 1e-3 m/s and work gain below 1e-3 J; of all trials. "
    "“Paper’s criterion” counts the answers only that the solver claims as solved, “criterion, any answer” whatever it "
    "returned. By our verdict: every condition holds to 1e-4 relative; of the trials not proven unsolvable.";

/// How the measures are called in the tables.
const char* words_for(Measure measure);

/// Whether the grid is of this kind and reads the paper as the tables do.
bool compared_with_paper(const Grid& grid, Kind kind);

/// The reading of redundancy; "–" for experiments without redundant contacts.
std::string reading_words(const Experiment& experiment, const std::string& reading);

bool is_experiment_six(const Experiment& experiment);

/// A solver of a table: one of the paper's, and the label of ours ("" where the store has none of it).
struct Contestant {
  std::optional<Family> family;
  std::string label;
};

using Picks = std::function<bool(const Experiment&)>;

/// The solvers of a table: for each of the paper's that it has, ours of that family, or one empty label; then the rest.
std::vector<Contestant> contestants(const std::vector<Grid>& grids, Kind kind, const Picks& picks,
                                    const std::vector<Family>& published);

/// The families of which the paper prints shares.
std::vector<Family> published_families(Kind kind);

/// What stands instead of a number where a solver refused some of the problems: a refusal is no failure to solve, and
/// a share of the rest is not comparable.
Entry refused_entry(const Grid& grid);

/// "" for a whole grid; else why it is absent, or what it refused.
std::string why_no_numbers(const Summary& summary, const Contestant& contestant, const Grid* grid);

// SQL over the store's views that repeats what a table counts. Each is one SELECT.

/// Per set and swept solver: parameterisations, trials of the first, worst, average and best share by both measures.
std::string rates_query(Kind kind);
/// Per set and swept solver: counts, means and maxima of time and violation over all parameterisations.
std::string measurements_query();
/// Per set, swept solver and parameterisation: trials, solved by both measures, unsolvable.
std::string cells_query();
/// Per set and solver, swept or not: trials, solved by both measures, unsolvable, false claims.
std::string totals_query();

/// The shares solved over the two tolerances of Lemke's algorithm on one set.
struct ToleranceMap {
  const Grid* grid = nullptr;
  std::vector<double> pivot_tolerances;  ///< ascending: columns
  std::vector<double> zero_tolerances;   ///< ascending: rows
  std::vector<const Cell*> cells;        ///< [zero * columns + pivot]; nullptr where the grid has none

  const Cell* at(std::size_t pivot, std::size_t zero) const { return cells[zero * pivot_tolerances.size() + pivot]; }
};

/// One map per grid whose parameterisations have both tolerances, their own or those of a solver they wrap, and differ
/// in both. Where other settings vary too, the first cell at a pair of tolerances stands for it.
std::vector<ToleranceMap> tolerance_maps(const Summary& summary, const std::vector<Grid>& grids);

/// One record per map and cell, for tolerance-map.csv.
nlohmann::ordered_json tolerance_maps_json(const Summary& summary, const std::vector<ToleranceMap>& maps);
nlohmann::ordered_json tolerance_maps_example();

}  // namespace lcpbench::paper
