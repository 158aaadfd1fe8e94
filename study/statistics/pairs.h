#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "study/statistics/statistics.h"

namespace lcpbench {

/// Calls visit(x, y) for each x of `a` and y of `b` with the same key. Both lists are in ascending order of the key,
/// which may occur several times in `a` and once in `b`.
/// @param key  a member of the elements, or a function of them
template <class A, class B, class Key, class Visit>
void for_each_pair(const A& a, const B& b, Key key, Visit visit) {
  auto other = b.begin();
  for (const auto& element : a) {
    while (other != b.end() && std::invoke(key, *other) < std::invoke(key, element)) ++other;
    if (other == b.end()) return;
    if (std::invoke(key, *other) == std::invoke(key, element)) visit(element, *other);
  }
}

/// Times of two solvers on the problems that both solved.
struct PairedTimes {
  std::vector<double> first;
  std::vector<double> second;

  /// Leaves a pair out if one of its times is missing (NaN).
  void add(double first_s, double second_s) {
    if (std::isnan(first_s) || std::isnan(second_s)) return;
    first.push_back(first_s);
    second.push_back(second_s);
  }
};

}  // namespace lcpbench
