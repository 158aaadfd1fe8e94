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

/// How many problems two solvers solved together and alone; or one solver on two sets that have the same problems.
struct PairedCounts {
  std::int64_t both = 0;
  std::int64_t only_first = 0;
  std::int64_t only_second = 0;
  std::int64_t neither = 0;

  void add(bool first, bool second) {
    ++(first ? (second ? both : only_first) : (second ? only_second : neither));
  }
  std::int64_t problems() const { return both + only_first + only_second + neither; }
  /// McNemar's exact test.
  double p_value() const { return mcnemar_exact(only_first, only_second); }
};

}  // namespace lcpbench
