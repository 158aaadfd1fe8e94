#pragma once

#include "core/problem.h"
#include "native/auto/features.h"
#include "native/auto/race.h"
#include "native/auto/report.h"

namespace lcpbench {

/// What a method is predicted to take for a problem with these features, by the table of prediction_table.h. O(kFeatures)
/// @param frictional whether friction can act at some contact
Entrant predict(AutoMethod method, bool frictional, const Features& features);

}  // namespace lcpbench
