#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "study/paper/tables.h"
#include "study/report/solver_comparison.h"
#include "study/report/speed_error.h"
#include "study/summary/summary.h"

namespace lcpbench::report {

/// A picture and the words that stand for it.
struct Figure {
  std::string svg;
  std::string alternative;  ///< for those who do not see it
  std::string file;         ///< its place below the report's folder, once it has one
};

/// The cells of a set that a picture shows: single solvers, not the cells of a sweep, that took the set's problems.
std::vector<const Cell*> drawn_cells(const Summary& summary, std::size_t set);

/// Speed against error of every solver on one set, each point labelled, the frontier drawn, and under it the shares
/// that each answered wrongly or not at all.
/// @returns nullopt when no solver of the set can be drawn.
std::optional<Figure> speed_error_figure(const Summary& summary, const SpeedError& speed_error);

/// Error (99th percentile) and cost of every solver over the condition number, one line each.
/// @returns nullopt when no solver has a point at two conditions.
std::optional<Figure> conditioning_figure(const Summary& summary, const Conditioning& family);

/// The share of a set's problems that each solver answered within an error, over the error: the whole distribution.
/// @returns nullopt when no solver of the set can be drawn.
std::optional<Figure> error_distribution_figure(const Summary& summary, std::size_t set);

/// Share of a set's problems, those proven unsolvable left out, that each solver solved within a time.
/// @returns nullopt when no solver solved any.
std::optional<Figure> time_ecdf_figure(const Summary& summary, const SetComparison& comparison);

/// The same share answered within an error, whatever the solvers claimed.
/// @returns nullopt when there is no answer.
std::optional<Figure> error_ecdf_figure(const Summary& summary, const SetComparison& comparison);

/// Two heat maps side by side, by our verdict and by the paper's criterion: the share solved at each pair of
/// tolerances, its number in each field, on a scale that is fixed from 0 to 100 % and is told apart with any colour
/// vision.
Figure tolerance_figure(const Summary& summary, const paper::ToleranceMap& map);

}  // namespace lcpbench::report
