#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/spec.h"
#include "study/paper/intervals.h"
#include "study/summary/summary.h"

// Drumwright and Shell (2012), "Extensive analysis of linear complementarity problem (LCP) solver performance on
// randomly generated rigid body contact problems": the sweeps of a store on the paper's sets, as its tables count them.

namespace lcpbench::paper {

/// A set of the paper's problems, its name taken apart.
struct PaperSet {
  std::string kind;        ///< "monotone" or "copositive"
  std::string experiment;  ///< "exp5-1e8"
  bool redundant = false;  ///< it has dependent contacts, so that the readings of redundancy differ
  std::string redundancy;  ///< "multiple" (the default) or "combination"
  /// Options but `redundancy`, "key=value,key=value"; "" for the problems that the tables compare with the paper.
  std::string other_readings;
};

/// nullopt for a set that is not "paper/<kind>/<experiment>".
std::optional<PaperSet> paper_set(const std::string& name);

/// One solver on one of the paper's sets, over its grid of parameters.
struct Grid {
  std::size_t set = 0;  ///< index into Summary::sets
  PaperSet problems;
  std::string solver;  ///< with what all cells share off its defaults: "lemke", "regularized{test=tried}"
  std::string sweep;   ///< the grid's name
  std::string isa;
  std::string build;               ///< library and version
  std::string label;               ///< the solver as tables name it: with the grid unless that is the paper's, with the
                                   ///< instruction-set level, library and version where the store has it at several
  std::vector<const Cell*> cells;  ///< in the order of Summary::solvers

  /// The most problems that a cell refused; more than 0 leaves a grid out of every comparison, because a refusal is no
  /// failure to solve. Cells that refused all of their problems are not in the grid.
  std::int64_t refused() const;
  /// "refused 300 of 2000: <reason>"; "" for a grid without refusals.
  std::string refusal() const;
  /// The fewest trials of any cell.
  std::int64_t trials() const;
};

/// All grids of a summary on the paper's sets, by set, then solver. They point into `summary`.
std::vector<Grid> grids(const Summary& summary);

/// The solver that `regularized{...}` wraps, in the form of Grid::solver; "" for a solver that wraps none.
std::string wrapped_solver(const std::string& solver);

/// The solver of the paper's tables that this one stands for: "Lemke" for lemke, "PATH" for path, "IP" for primal_dual
/// (the interior point method), and for `regularized` that of the solver that it wraps. "" for all others.
std::string family_of(const std::string& solver);

/// Whether the solver, or the one that it wraps, follows the rules of the authors' public code (rules=2012).
bool follows_rules_2012(const std::string& solver);

/// What "solved" means in a rate.
enum class Measure {
  kCriterion,     ///< the paper's: claimed solved, violation < 1e-3 m/s, work gain < 1e-3 J; of all trials
  kCriterionAny,  ///< the same of whatever was returned, claimed or not
  kVerdict,       ///< this project's: every condition holds to 1e-4; of the trials that are not proven unsolvable
};
inline constexpr std::array<Measure, 3> kMeasures{Measure::kCriterion, Measure::kCriterionAny, Measure::kVerdict};
/// "criterion", "criterion_any", "verdict".
const char* name_of(Measure measure);

Proportion solved_share(const Cell& cell, Measure measure);

/// Worst, average and best over a grid.
struct GridRange {
  Proportion worst;
  Proportion average;
  Proportion best;
  const Cell* worst_cell = nullptr;
  const Cell* best_cell = nullptr;
  const Cell* chosen = nullptr;  ///< best on the even trials; the first of equals
  Proportion chosen_even;
  Proportion held_out;  ///< its share on the odd trials
  /// The odd trials' share of the cell that is worst on the even ones: a range free of the selection that makes the
  /// difference of best and worst grow with the number of cells.
  Proportion worst_held_out;
  double sigma = kNoNumber;  ///< sample standard deviation of the shares; NaN for one cell
};

/// Cells all of whose problems are unsolvable have no share and are passed over; all pointers null when no cell has
/// one.
GridRange range_of(const Grid& grid, Measure measure);

enum class Quantity { kTimeSolved, kTimeAll, kViolation };

/// At the parameterisation chosen on the even trials, of the odd ones; `measure` says what solved means and chooses.
PooledMean at_best(const Grid& grid, Quantity quantity, Measure measure);
/// Over all parameterisations, all trials.
PooledMean over_all(const Grid& grid, Quantity quantity, Measure measure);

}  // namespace lcpbench::paper
