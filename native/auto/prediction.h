#pragma once

#include <array>

#include "core/problem.h"
#include "native/auto/features.h"
#include "native/auto/race.h"
#include "native/auto/report.h"

namespace lcpbench {

/// What a method is predicted to take for a problem, which has these features, by the table of prediction_table.h. The
/// load of a dense method follows from its sizes. O(kFeatures) @param idle coordinates that no contact moves
Entrant predict(AutoMethod method, const Problem& problem, Index idle, const std::array<double, kFeatures>& features);

/// The load alone of contact_lemke and active_set. O(1)
Entrant predict_load(AutoMethod method, const Problem& problem, Index idle);

}  // namespace lcpbench
