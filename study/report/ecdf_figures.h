#pragma once

#include <optional>

#include "study/report/solver_comparison.h"
#include "study/report/figures.h"

namespace lcpbench::report {

/// Share of a set's problems, those proven unsolvable left out, that each solver solved within a time.
/// @returns nullopt when no solver solved any.
std::optional<Figure> time_ecdf_figure(const Summary& summary, const SetComparison& comparison);

/// The same share answered within an error, whatever the solvers claimed.
/// @returns nullopt when there is no answer.
std::optional<Figure> error_ecdf_figure(const Summary& summary, const SetComparison& comparison);

}  // namespace lcpbench::report
