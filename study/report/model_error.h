#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "study/report/figures.h"
#include "study/summary/summary.h"

// The error of the friction model beside that of the solver, over all captured steps with friction.

namespace lcpbench::report {

/// One solver on the steps that it solved and of which both errors and the time are known. Its errors are 90th
/// percentiles: at rest, as most steps are, no model has an error.
struct ModelErrorPoint {
  std::size_t solver = 0;  ///< index into Summary::solvers
  std::int64_t steps = 0;
  double time_s = 0;          ///< median
  double total_m_per_s = 0;   ///< the residual of the round cone's conditions: model and solver together
  double solver_m_per_s = 0;  ///< the residual of the conditions that it solves
};

struct ModelErrors {
  std::vector<ModelErrorPoint> points;  ///< by time
  std::int64_t steps = 0;               ///< that some solver has a model's error of
};

/// Of the single solvers on the sets of scenes. O(answers log answers)
ModelErrors model_errors(const Summary& summary);

/// A bar for each solver at its time, as high as the total error, the solver's part of it shaded, with a list of the
/// numbers below. @returns nullopt where there is no point.
std::optional<Figure> model_error_figure(const Summary& summary, const ModelErrors& errors);

/// What the picture shows, in words: HTML.
std::string model_error_words();

}  // namespace lcpbench::report
