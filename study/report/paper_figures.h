#pragma once

#include "study/paper/tolerance_map.h"
#include "study/report/figures.h"

namespace lcpbench::report {

/// Two heat maps side by side, by our verdict and by the paper's criterion: the share solved at each pair of
/// tolerances, its number in each field, on a scale that is fixed from 0 to 100 % and is told apart with any colour
/// vision.
///
Figure tolerance_figure(const Summary& summary, const paper::ToleranceMap& map);

}  // namespace lcpbench::report
