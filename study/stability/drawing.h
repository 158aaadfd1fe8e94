#pragma once

#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "generators/random.h"
#include "study/stability/contact_changes.h"
#include "study/stability/transformations.h"

// Draws that transformations of contact problems and of scenes have in common.

namespace lcpbench {

/// kg to g, m to mm.
inline constexpr double kUnit = 1000;
/// How far a near duplicate is off.
inline constexpr double kNearby = 0x1p-30;

inline EntryChange times(double factor) {
  return [factor](double x) { return x * factor; };
}

inline EntryChange over(double factor) {
  return [factor](double x) { return x / factor; };
}

/// A transformation after which answers are read as they are.
inline Transformation with_answers_as_they_are() {
  Transformation result;
  result.velocity_back = [](Vector velocity) { return velocity; };
  result.unknowns_back = [](Vector z) { return z; };
  return result;
}

/// Velocities of rigid bodies in mm/s and rad/s, in m/s and rad/s.
inline Vector linear_velocities_over_unit(Vector velocity) {
  for (Index i = 0; i < velocity.size(); ++i) {
    if (!is_angular(i)) velocity(i) /= kUnit;
  }
  return velocity;
}

inline std::vector<Index> first_indices(Index count) {
  std::vector<Index> indices(static_cast<std::size_t>(count));
  std::iota(indices.begin(), indices.end(), Index{0});
  return indices;
}

/// A Fisher-Yates shuffle from the last place down.
inline std::vector<Index> shuffled(DrawSequence& draws, Index count) {
  std::vector<Index> order = first_indices(count);
  for (std::size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[static_cast<std::size_t>(draws.integer(0, static_cast<std::int64_t>(i) - 1))]);
  }
  return order;
}

inline std::vector<Index> inverse_order(const std::vector<Index>& order) {
  std::vector<Index> inverse(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) inverse[static_cast<std::size_t>(order[i])] = static_cast<Index>(i);
  return inverse;
}

}  // namespace lcpbench
