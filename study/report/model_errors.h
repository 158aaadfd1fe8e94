#pragma once

#include "study/output/json_output.h"
#include "study/store/store.h"
#include "study/summary/summary.h"

namespace lcpbench::report {

/// How far the models of soft contacts are from hard contacts with Coulomb's friction: a record for each step of a set
/// whose hard version, `changed{of=SET,by=hard}`, is in the store too. `relaxation_m_per_s` is the largest difference
/// of a velocity at a contact between verified answers with the convex model and with the round cone,
/// `softness_m_per_s` that between answers with one model (the cone, else the pyramid) to the step and to its hard
/// version. Null where an answer is missing, or a problem is no longer that of the store.
Json model_errors(Store& store, const Summary& summary);

}  // namespace lcpbench::report
