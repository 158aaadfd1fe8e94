#pragma once

#include <nlohmann/json.hpp>

#include "study/store/store.h"
#include "study/summary/summary.h"

namespace lcpbench::report {

/// How differently the verified answers to a captured step with friction move its contacts: a record for each step that
/// two verified answers solve, of solvers at single settings with the pyramid of the problem. `before_m_per_s` is the
/// fastest velocity at a contact before the impact, `spread_m_per_s` the largest difference along a normal or a direction
/// of friction, at `contact`, between the answers of `solver` and `other`; `differs`: by more than verified answers with
/// one velocity may. The step is read from its scene again: sets that cannot be opened, and problems that are no longer
/// those of the store, are left out.
nlohmann::ordered_json velocity_spreads(Store& store, const Summary& summary);

/// A record without values.
nlohmann::ordered_json velocity_spread_example();

}  // namespace lcpbench::report
