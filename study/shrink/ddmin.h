#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/types.h"

namespace lcpbench {

/// Delta debugging: a subset of `units` that still fails and of which no single unit can be left out [Zeller,
/// Hildebrandt 2002]. The subset is a function of the units and of the answers of `fails` alone. Calls `fails`
/// O(n^2) times at worst, n the number of units.
/// @param fails  bool(const std::vector<Index>& kept); true for all units together
template <class Fails>
std::vector<Index> minimal_subset(std::vector<Index> units, Fails&& fails) {
  if (units.empty() || fails(std::vector<Index>())) return {};
  for (std::size_t parts = 2; units.size() > 1;) {
    parts = std::min(parts, units.size());
    // Keeps one of the parts alone, or all but one of them, if that fails.
    const auto smaller = [&](bool alone) {
      for (std::size_t part = 0; part < parts; ++part) {
        const auto begin = units.begin() + static_cast<std::ptrdiff_t>(part * units.size() / parts);
        const auto end = units.begin() + static_cast<std::ptrdiff_t>((part + 1) * units.size() / parts);
        std::vector<Index> kept(begin, end);
        if (!alone) {
          kept.assign(units.begin(), begin);
          kept.insert(kept.end(), end, units.end());
        }
        if (!fails(kept)) continue;
        units = std::move(kept);
        return true;
      }
      return false;
    };
    if (smaller(true)) {
      parts = 2;
    } else if (parts > 2 && smaller(false)) {  // of two halves each is the rest of the other
      parts = std::max<std::size_t>(parts - 1, 2);
    } else if (parts < units.size()) {
      parts *= 2;
    } else {
      break;
    }
  }
  return units;
}

}  // namespace lcpbench
