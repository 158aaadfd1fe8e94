#pragma once

#include <array>

#include "native/auto/features.h"
#include "native/auto/report.h"

namespace lcpbench::prediction {

struct Row {
  std::array<double, kSizes> load;      ///< of log2(work of load())
  std::array<double, kFeatures> solve;  ///< of log2(work of a solve)
};

// clang-format off
inline constexpr Row kContactLemke{{7, 1, 1, 1, 0}, {6, 1, 2, 0.5, 0, 0, 0, 0, 0, 0}};
inline constexpr Row kFrictionIpm{{10, 1, 0, 1, 1}, {12, 0, 1, 1, 2, 0, 0.5, 0, 0, 0.1}};
inline constexpr Row kPsor{{8, 1, 0, 1, 0}, {9, 1.5, 0, 1, 0, 0.5, 0, 0, 0.1, 0.1}};
inline constexpr Row kActiveSet{{4, 1, 2, 0, 0}, {2, 1, 2, 0, 0, 0, 0, 0, 0, 0}};
inline constexpr Row kVelocityIpm{{10, 1, 0, 0, 1}, {9, 0, 1, 0, 2, 0, 0, 0, 0, 0}};
inline constexpr Row kSweeps{{8, 1, 0, 0, 0}, {7, 1.5, 0, 0, 0, 0.5, 0, 0, 0.1, 0.1}};
// clang-format on

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
