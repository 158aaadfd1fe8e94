#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "study/summary/summary.h"
#include "study/store/store.h"

namespace lcpbench::report {

/// How differently the verified answers to one captured step with friction move its contacts.
struct VelocitySpread {
  std::size_t set = 0;  ///< index into Summary::sets
  std::int64_t trial = 0;
  std::int64_t answers = 0;   ///< verified, of solvers at single settings with the pyramid of the problem
  double before_m_per_s = 0;  ///< the fastest velocity at a contact before the impact
  double spread_m_per_s = 0;  ///< largest difference along a normal or a direction of friction
  std::int64_t contact = -1;  ///< where that is; -1: nowhere
  std::string solver, other;  ///< whose answers differ so; "" where none do
  bool differs = false;       ///< by more than verified answers with one velocity may
};

/// Of every captured step that two verified answers solve. The step is read from its scene again: sets that cannot be
/// opened, and problems that are no longer those of the store, are left out.
std::vector<VelocitySpread> velocity_spreads(Store& store, const Summary& summary);

/// One record each.
nlohmann::ordered_json velocity_spread_json(const Summary& summary, const std::vector<VelocitySpread>& spreads);

}  // namespace lcpbench::report
