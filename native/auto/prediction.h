#pragma once

#include "core/problem.h"
#include "native/auto/features.h"
#include "native/auto/race.h"
#include "native/auto/report.h"

namespace lcpbench {

/// What a method is predicted to take for a problem, which has these features, by the table of prediction_table.h. The load
/// of a dense method follows from its sizes. O(kFeatures)
Entrant predict(AutoMethod method, const Problem& problem, const Features& features);

}  // namespace lcpbench
