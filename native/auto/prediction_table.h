#pragma once

#include <array>

#include "native/auto/features.h"
#include "native/auto/report.h"

namespace lcpbench::prediction {

struct Row {
  double weight;                        ///< nanoseconds for a unit of work
  std::array<double, kSizes> load;      ///< of log2(nanoseconds of load()); of dense methods the sizes tell
  std::array<double, kFeatures> solve;  ///< of log2(weighted work of a solve)
};

// Fitted by `auto_table fit`, see results/auto/README.md.
#include "native/auto/prediction_rows.inc"

/// kSweeps: psor without friction.
constexpr const Row& row_of(AutoMethod method, bool frictional) {
  switch (method) {
    case AutoMethod::kContactLemke: return kContactLemke;
    case AutoMethod::kVelocityIpm: return kVelocityIpm;
    case AutoMethod::kFrictionIpm: return kFrictionIpm;
    case AutoMethod::kPsor: return frictional ? kPsor : kSweeps;
    default: return kActiveSet;
  }
}

}  // namespace lcpbench::prediction
