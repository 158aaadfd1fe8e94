#pragma once

#include <cstdint>
#include <limits>

#include "native/proofs/exact_search.h"

namespace lcpbench::testing {

/// What trying every support of z in exact arithmetic says of an LCP of at most ExactSearch::kMaxSize rows.
struct Enumerated {
  bool solvable = false;
  Vector z;  ///< the first solution, each entry rounded once; empty where there is none
};

inline Enumerated enumerate(const Lcp& lcp) {
  ExactSearch search;
  search.load(lcp);
  const auto end =
      search.run(std::numeric_limits<double>::infinity(), std::numeric_limits<std::int64_t>::max());
  if (end != ExactSearch::End::kFound) return {};
  return {true, search.z()};
}

}  // namespace lcpbench::testing
