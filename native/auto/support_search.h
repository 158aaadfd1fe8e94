#pragma once

#include <array>

#include "core/lcp.h"
#include "core/quad.h"
#include "native/bare_lcp_test.h"

namespace lcpbench {

/// Looks for a solution of a small LCP of any class by going through all supports of z, in 113 bits.
///
/// Supports whose block of M is singular are passed over: what has no other solutions is not found. 2^n eliminations of
/// order <= n. Allocates nothing. See `enumeration` for the exact method, which decides every problem.
class SupportSearch {
 public:
  static constexpr Index kMaxSize = 12;

  /// @pre lcp.size() <= kMaxSize
  void load(const Lcp& lcp);

  /// The first z, in the order of the number whose bit i says that i is in the support, that passes `test` and proves
  /// nothing against itself. @param z n entries, whatever they are where there is none @returns whether there is one
  bool run(double deadline_s, BareLcpTest& test, Vector& z);

 private:
  bool solve(unsigned support, Vector& z);

  Index n_ = 0;
  std::array<std::array<Quad, kMaxSize + 1>, kMaxSize> data_;  ///< [M -q]
  std::array<std::array<Quad, kMaxSize + 1>, kMaxSize> rows_;  ///< of the support, being eliminated
  std::array<Index, kMaxSize> members_;
};

}  // namespace lcpbench
