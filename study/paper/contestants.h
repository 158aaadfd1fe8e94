#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "study/paper/tables.h"

/// What the tables of shares and those of times and violations have in common.
namespace lcpbench::paper {

/// Stands where there is no number.
inline constexpr const char* kAbsent = "–";

inline constexpr const char* kSolvedNote =
    "Solved by the paper’s criterion: claimed solved, normal violation below 1e-3 m/s and work gain below 1e-3 J; of "
    "all trials. By our verdict: every condition holds to 1e-4 relative; of the trials not proven unsolvable.";

/// How the two measures are called in the tables.
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

}  // namespace lcpbench::paper
