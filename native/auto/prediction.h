#pragma once

#include <array>

#include "core/problem.h"
#include "native/auto/features.h"
#include "native/auto/race.h"
#include "native/auto/report.h"

namespace lcpbench {

/// What a method is predicted to take for a problem, which has these features, by the table below. The load of a dense
/// method follows from its sizes. O(kFeatures) @param idle coordinates that no contact moves
Entrant predict(AutoMethod method, const Problem& problem, Index idle, const std::array<double, kFeatures>& features);

/// The load alone of contact_lemke and active_set. O(1)
Entrant predict_load(AutoMethod method, const Problem& problem, Index idle);

namespace prediction {

struct Row {
  double weight;                        ///< nanoseconds for a unit of work
  std::array<double, kSizes> load;      ///< of log2(nanoseconds of load()); of dense methods the sizes tell
  std::array<double, kFeatures> solve;  ///< of log2(weighted work of a solve)
};

// Fitted by native/auto/measure/auto_fit.py, see results/auto/README.md.
#include "native/auto/prediction_rows.inc"

/// kSweeps: psor without friction.
constexpr const Row& row_of(AutoMethod method, bool frictional) {
  const Row& psor = frictional ? kPsor : kSweeps;
  const std::array<const Row*, kAutoMethods> rows{&kActiveSet, &kContactLemke, &kVelocityIpm, &kFrictionIpm,
                                                  &psor, &kContactIpm, &psor};
  return *rows[static_cast<std::size_t>(method)];
}

}  // namespace prediction
}  // namespace lcpbench
